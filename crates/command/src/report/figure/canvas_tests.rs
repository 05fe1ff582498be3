//! Comparison of the paths drawn as pixels and on PDF pages with the elements of the SVG that `plotters` writes.

use super::*;
use crate::report::figure::{Curve, FONT_FILE, Figure, Look, Sheet, UNIT};
use plotters::prelude::IntoDrawingArea;
use tiny_skia::{PathSegment, Pixmap};

/// Path passed to a canvas: filled or not, colour, line width if not filled, in tenths of a user unit.
struct Traced {
    filled: bool,
    colour: [u8; 3],
    width: f32,
    path: Path,
}

/// Canvas that records its paths.
struct Tracing {
    size: [u32; 2],
    paths: Vec<Traced>,
}

impl Canvas for Tracing {
    fn size(&self) -> [u32; 2] {
        self.size
    }

    fn place(&self) -> Transform {
        Transform::identity()
    }

    fn fill(&mut self, path: &Path, colour: BackendColor, place: Transform) {
        let path = path.clone().transform(place).expect("a path of finite numbers");
        self.paths.push(Traced { filled: true, colour: colour.rgb.into(), width: 0.0, path });
    }

    fn stroke(&mut self, path: &Path, colour: BackendColor, width: f32) {
        self.paths.push(Traced { filled: false, colour: colour.rgb.into(), width, path: path.clone() });
    }
}

/// Figure with lines, dashes and dots, whose first and last points differ, with marks and names.
fn figure(equal: bool) -> Figure {
    let wave = |n: usize| (0..12).map(f64::from).map(|x| [x, (0.7 * x + n as f64).sin() + x]).collect();
    let mut curves: Vec<Curve> = (0..9).map(|n| Curve::nth(n, format!("wing{n}"), wave(n))).collect();
    curves[3].look = Look::Dots;
    curves[4].points.truncate(1);
    let marks = vec![(2.5, "latched".to_owned()), (7.0, "released".to_owned())];
    let [x_label, y_label] = ["time (s)", "height (m)"].map(str::to_owned);
    Figure { title: "Heights".to_owned(), x_label, y_label, curves, marks, equal, ..Figure::default() }
}

/// Elements of an SVG: names, attributes and text.
fn elements(svg: &str) -> Vec<(&str, &str)> {
    let tags = svg.split('<').skip(1).filter(|tag| !tag.starts_with(['/', '!', '?']));
    tags.filter_map(|tag| tag.split_once(' ')).filter(|(name, _)| *name != "svg").collect()
}

fn attribute<'t>(tag: &'t str, name: &str) -> &'t str {
    let begin = format!(" {name}=\"");
    let at = tag.find(&begin).map(|at| at + begin.len());
    at.and_then(|at| tag[at..].split('"').next())
        .or(tag.strip_prefix(&begin[1..]).and_then(|rest| rest.split('"').next()))
        .unwrap_or_else(|| panic!("no {name} in {tag}"))
}

fn number(tag: &str, name: &str) -> f32 {
    attribute(tag, name).parse().unwrap_or_else(|_| panic!("{name} in {tag}"))
}

fn rgb(text: &str) -> [u8; 3] {
    [1, 3, 5].map(|at| u8::from_str_radix(&text[at..at + 2], 16).unwrap_or_else(|_| panic!("{text}")))
}

/// Vertices of a path, and whether it is closed.
fn corners(path: &Path) -> (Vec<[f32; 2]>, bool) {
    let (mut list, mut closed) = (Vec::new(), false);
    for segment in path.segments() {
        match segment {
            PathSegment::MoveTo(to)
            | PathSegment::LineTo(to)
            | PathSegment::QuadTo(_, to)
            | PathSegment::CubicTo(.., to) => {
                list.push([to.x, to.y]);
            }
            PathSegment::Close => closed = true,
        }
    }
    (list, closed)
}

fn points(tag: &str) -> Vec<[f32; 2]> {
    let point = |pair: &str| {
        let (x, y) = pair.split_once(',').expect("x,y");
        [x, y].map(|c| c.parse().expect("a number"))
    };
    attribute(tag, "points").split_whitespace().map(point).collect()
}

/// Records the paths of a figure.
fn traced(figure: &Figure, sheet: Sheet) -> Vec<Traced> {
    let mut canvas = Tracing { size: sheet.size.map(|length| length * UNIT), paths: Vec::new() };
    figure.draw(sheet, &Backend::new(&mut canvas, FONT_FILE).into_drawing_area()).expect("a figure");
    canvas.paths
}

/// Names of two curves that end at one height are moved apart: the stroke to each goes from the height of the end of its curve to that of
/// the name.
#[test]
fn strokes_lead_from_curves_to_their_names() {
    let ends = |n: usize| vec![[0.0, n as f64], [1.0, 2.0]];
    let curves: Vec<Curve> = (0..2).map(|n| Curve::nth(n, format!("wing{n}"), ends(n))).collect();
    let svg = Figure { curves, ..Figure::default() }.svg(Sheet::default()).expect("a figure");
    let lines: Vec<Vec<[f32; 2]>> =
        elements(&svg).into_iter().filter(|(name, _)| *name == "polyline").map(|(_, tag)| points(tag)).collect();
    for name in ["wing0", "wing1"] {
        let (_, label) = elements(&svg).into_iter().find(|(_, tag)| tag.contains(name)).expect("a name");
        let [x, y] = [number(label, "x"), number(label, "y")];
        let stroke = lines.iter().find(|line| line.len() == 2 && line[1][1] == y && line[1][0] < x).expect("a stroke");
        assert_ne!(stroke[0][1], y, "moved apart");
        let curve =
            lines.iter().find(|line| line.last().is_some_and(|end| end[1] == stroke[0][1] && end[0] < stroke[0][0]));
        assert!(curve.is_some(), "{name}: no curve ends where {stroke:?} begins");
    }
}

/// Every element of the SVG has a path, in the same order, with the same vertices, colour and width, open for a line and closed for a
/// filled shape. Texts are at their anchors, within a third of their height, since the glyphs of the two fonts may differ.
#[test]
fn paths_are_the_elements_of_the_svg() {
    for equal in [false, true] {
        let (figure, sheet) = (figure(equal), Sheet { size: [800, 500], scale: 1.0 });
        let svg = figure.svg(sheet).expect("a figure");
        let (elements, paths) = (elements(&svg), traced(&figure, sheet));
        assert_eq!(elements.len(), paths.len());
        for ((name, tag), path) in elements.into_iter().zip(&paths) {
            let (corners, closed) = corners(&path.path);
            let bounds = path.path.bounds();
            let (expected, ink) = match name {
                "polyline" => (points(tag), attribute(tag, "stroke")),
                "polygon" => (points(tag), attribute(tag, "fill")),
                "line" => {
                    let ends = [["x1", "y1"], ["x2", "y2"]].map(|end| end.map(|name| number(tag, name)));
                    (ends.to_vec(), attribute(tag, "stroke"))
                }
                "rect" => {
                    let [x, y, width, height] = ["x", "y", "width", "height"].map(|name| number(tag, name));
                    let ink = attribute(tag, if path.filled { "fill" } else { "stroke" });
                    (vec![[x, y], [x + width, y], [x + width, y + height], [x, y + height]], ink)
                }
                "circle" => {
                    let [x, y, radius] = ["cx", "cy", "r"].map(|name| number(tag, name));
                    let sides = [bounds.left(), bounds.right(), bounds.top(), bounds.bottom()];
                    let due = [x - radius, x + radius, y - radius, y + radius];
                    assert!(sides.iter().zip(due).all(|(side, due)| (side - due).abs() < 0.01), "{tag} {bounds:?}");
                    assert!(path.filled && path.colour == rgb(attribute(tag, "fill")), "{tag}");
                    continue;
                }
                "text" => {
                    let [x, y, size] = ["x", "y", "font-size"].map(|name| number(tag, name));
                    let turned = tag.contains("rotate(");
                    let [along, across] = match turned {
                        false => [[bounds.left(), bounds.right()], [bounds.top(), bounds.bottom()]],
                        true => [[bounds.bottom(), bounds.top()], [bounds.left(), bounds.right()]],
                    };
                    let [start, level] = if turned { [y, x] } else { [x, y] };
                    let anchor = match attribute(tag, "text-anchor") {
                        "start" => along[0],
                        "middle" => 0.5 * (along[0] + along[1]),
                        "end" => along[1],
                        other => panic!("{other}"),
                    };
                    let third = size / 3.0;
                    assert!((anchor - start).abs() < third, "{tag} {bounds:?}");
                    assert!(across[0] - third < level && level < across[1] + third, "{tag} {bounds:?}");
                    assert!(path.filled && path.colour == rgb(attribute(tag, "fill")), "{tag}");
                    continue;
                }
                other => panic!("{other} has no path"),
            };
            assert_eq!(corners, expected, "{name} {tag}");
            assert_eq!((path.filled, path.colour), (closed, rgb(ink)), "{name} {tag}");
            if !path.filled {
                assert_eq!(path.width, number(tag, "stroke-width"), "{name} {tag}");
            }
        }
    }
}

/// The PDF page has the same paths, in points and with y upwards: vertices and curves, closing, colour, width, drawing style.
#[test]
fn a_page_has_every_path() {
    let (figure, sheet) = (figure(false), Sheet { size: [800, 500], scale: 1.0 });
    let pdf = figure.pdf(sheet).expect("a figure");
    let text = String::from_utf8_lossy(&pdf);
    let content = text.split("stream\n").nth(1).expect("the content").strip_suffix("\nend").expect("its end");
    let (mut drawn, mut path) = (Vec::new(), (Vec::new(), false));
    let (mut inks, mut width) = ([[0.0; 3]; 2], 0.0);
    for line in content.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        let (operator, numbers) = words.split_last().expect("an operator");
        let numbers: Vec<f32> = numbers.iter().map(|word| word.parse().expect("a number")).collect();
        match *operator {
            "m" | "l" | "c" => path.0.push([numbers[numbers.len() - 2], numbers[numbers.len() - 1]]),
            "h" => path.1 = true,
            "rg" => inks[1] = [numbers[0], numbers[1], numbers[2]],
            "RG" => inks[0] = [numbers[0], numbers[1], numbers[2]],
            "w" => width = numbers[0],
            "S" | "f" => {
                let filled = *operator == "f";
                let (corners, closed) = std::mem::take(&mut path);
                drawn.push((filled, inks[usize::from(filled)], if filled { 0.0 } else { width }, corners, closed));
            }
            "j" => {}
            other => panic!("{other} of the page is not compared"),
        }
    }
    let paths = traced(&figure, sheet);
    assert_eq!(drawn.len(), paths.len());
    // a tenth of a user unit in points
    let tenth = 0.075;
    for ((filled, ink, width, found, closed), path) in drawn.iter().zip(&paths) {
        let (corners, due_closed) = corners(&path.path);
        assert_eq!((*filled, *closed, found.len()), (path.filled, due_closed, corners.len()), "{:?}", path.path);
        assert!((width - path.width * tenth).abs() < 1e-4, "{width} {}", path.width);
        assert!(ink.iter().zip(path.colour).all(|(ink, due)| (255.0 * ink - f32::from(due)).abs() < 0.1), "{ink:?}");
        // coordinates of a page of 600 points are stored in single precision
        let near = |[x, y]: [f32; 2], [due_x, due_y]: [f32; 2]| {
            (x - due_x * tenth).abs() < 1e-3 && (375.0 - y - due_y * tenth).abs() < 1e-3
        };
        assert!(found.iter().zip(&corners).all(|(found, due)| near(*found, *due)), "{found:?}");
    }
}

/// The picture has the colour of a curve at the middle of each of its lines, and nowhere else.
#[test]
fn a_picture_has_a_curve_where_its_points_are() {
    let points: Vec<[f64; 2]> = vec![[0.0, 0.0], [1.0, 3.0], [2.0, 3.0], [3.0, 0.5], [4.0, 2.0]];
    let curve = Curve { name: String::new(), ..Curve::nth(1, "", points) };
    let figure = Figure { curves: vec![curve.clone()], ..Figure::default() };
    let sheet = Sheet { size: [400, 300], scale: 1.0 };
    let picture = Pixmap::decode_png(&figure.png(sheet).expect("a figure")).expect("a picture");
    let path = traced(&figure, sheet).into_iter().find(|path| path.colour == curve.colour).expect("the curve");
    let line: Vec<[f32; 2]> = corners(&path.path).0.iter().map(|point| point.map(|c| 0.1 * c)).collect();
    assert_eq!(line.len(), curve.points.len());
    let has = |x: u32, y: u32| {
        let pixel = picture.pixel(x, y).expect("inside").demultiply();
        let found = [pixel.red(), pixel.green(), pixel.blue()];
        found.iter().zip(curve.colour).all(|(found, due)| found.abs_diff(due) < 60)
    };
    for pair in line.windows(2) {
        let [x, y] = [0, 1].map(|axis| (0.5 * (pair[0][axis] + pair[1][axis])) as u32);
        assert!((x - 1..=x + 1).any(|x| (y - 1..=y + 1).any(|y| has(x, y))), "nothing at {x}, {y}");
    }
    let apart = |x: f32, y: f32| {
        let from = |pair: &[[f32; 2]]| {
            let [[ax, ay], [bx, by]] = [pair[0], pair[1]];
            let (dx, dy) = (bx - ax, by - ay);
            let share = (((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy)).clamp(0.0, 1.0);
            (x - ax - share * dx).hypot(y - ay - share * dy)
        };
        line.windows(2).map(from).fold(f32::INFINITY, f32::min)
    };
    for (x, y) in (0..400).flat_map(|x| (0..300).map(move |y| (x, y))).filter(|(x, y)| has(*x, *y)) {
        // half the line width plus the diagonal of a pixel
        assert!(apart(x as f32 + 0.5, y as f32 + 0.5) < 0.9 + 1.5, "the curve's colour at {x}, {y}");
    }
}
