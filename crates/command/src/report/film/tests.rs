use super::raster::Raster;
use super::*;
use crate::report::film::run::{Run, Vector};
use crate::report::recording::{Frame, Recording};
use crate::report::sample_tests::{recorded, shipped};
use nalgebra::{Isometry3, Perspective3, Point3, Rotation3};

const SIZE: [u32; 2] = [640, 360];

fn options() -> Options {
    Options { size: SIZE, frames_per_s: 30.0, speed: None, view: View::Iso, follows: None, span_s: [None; 2] }
}

fn film(recording: &Recording, options: &Options) -> Film {
    Film::new(&PackedRun::for_film(recording), options).unwrap()
}

/// Returns a frame without ground, paths and text.
fn bare(film: &Film, index: usize) -> (Vec<u8>, Camera) {
    let state = film.run.at(film.times_s[index]);
    let mut drawing = Drawing::default();
    machine::draw(&film.run, &film.measures, &state, &mut drawing);
    drawing.lines.clear();
    let camera = film.motion.at(&state);
    let mut raster = Raster::new(film.size);
    raster.clear(colours::BACKGROUND);
    drawing.draw(&camera, 1.0, &mut raster);
    (raster.pixels(), camera)
}

/// Leftmost, rightmost, uppermost and lowest pixel that is not background.
fn drawn_box(pixels: &[u8], [width, _]: [u32; 2]) -> [f64; 4] {
    let drawn = pixels.chunks(3).enumerate().filter(|(_, rgb)| **rgb != [255; 3]);
    let places = drawn.map(|(i, _)| (i % width as usize, i / width as usize));
    let none = [f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY];
    places.fold(none, |[left, right, top, low], (x, y)| {
        let (x, y) = (x as f64, y as f64);
        [left.min(x), right.max(x + 1.0), top.min(y), low.max(y + 1.0)]
    })
}

/// The ends of a wing are drawn where projection matrices of computer graphics place them, in each view and while it unfolds: within one
/// pixel, since pixels at the edge are partly covered.
#[test]
fn ends_are_where_the_projection_puts_them() {
    let mut machine = shipped("folding_wing");
    machine.gauges.clear();
    machine.bodies.iter_mut().for_each(|body| body.masses.clear());
    machine.gravity_m_s2 = Vector::zeros();
    let recording = recorded(machine, 120);
    for view in [View::Iso, View::Front, View::Side, View::Top] {
        for size in [SIZE, [300, 420]] {
            let mut film = film(&recording, &Options { view, size, ..options() });
            film.run.about.hinges.clear(); // the symbols of the hinges extend beyond the thin wing
            for index in [0, film.times_s.len() / 3, film.times_s.len() - 1] {
                let (pixels, camera) = bare(&film, index);
                let up = if view == View::Top { Vector::y() } else { Vector::z() };
                let target = camera.eye() - camera.outward;
                let eye = Isometry3::look_at_rh(&camera.eye().into(), &target.into(), &up);
                let [width, height] = size.map(f64::from);
                let half = (15.0_f64).to_radians().tan() * (height / width).max(1.0);
                let lens = Perspective3::new(width / height, 2.0 * half.atan(), 1e-3, 1e3);
                let state = film.run.at(film.times_s[index]);
                let seen = state.points().into_iter().map(|point| {
                    let projected = lens.project_point(&(eye * Point3::from(point)));
                    [0.5 * width * (1.0 + projected.x), 0.5 * height * (1.0 - projected.y)]
                });
                let seen: Vec<[f64; 2]> = seen.collect();
                let end = |i: usize, fold: fn(f64, f64) -> f64, from: f64| seen.iter().map(|p| p[i]).fold(from, fold);
                let expected = [
                    end(0, f64::min, f64::INFINITY),
                    end(0, f64::max, f64::NEG_INFINITY),
                    end(1, f64::min, f64::INFINITY),
                    end(1, f64::max, f64::NEG_INFINITY),
                ];
                let found = drawn_box(&pixels, size);
                let off = found.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(off < 1.0, "{view:?} {size:?} frame {index}: {found:?} and {expected:?}");
            }
        }
    }
}

/// Recording whose frames are copies of the first one, changed by `change` with the number of the frame.
fn moved(mut recording: Recording, count: usize, change: impl Fn(&mut Frame, usize)) -> Recording {
    let first = recording.frames[0].clone();
    recording.frames = (0..count)
        .map(|i| {
            let mut frame = first.clone();
            frame.time_s = 0.1 * i as f64;
            change(&mut frame, i);
            frame
        })
        .collect();
    recording
}

/// Rows of a frame below the clock.
fn below_the_clock(pixels: &[u8]) -> &[u8] {
    &pixels[3 * SIZE[0] as usize * 30..]
}

/// Frames of a model that does not move are bit-identical, with a fixed or moving camera, for any previous contents of the buffer.
#[test]
fn a_machine_at_rest_does_not_flicker() {
    for name in ["folding_wing", "folding_wing_in_tunnel", "flying_wing"] {
        let still = moved(recorded(shipped(name), 1), 6, |_, _| ());
        for follows in [false, true] {
            let film = film(&still, &Options { follows: Some(follows), ..options() });
            let first = film.frame(0);
            let mut others = (1..film.times_s.len()).step_by(7).map(|index| film.frame(index));
            assert!(others.all(|other| below_the_clock(&other) == below_the_clock(&first)), "{name}");
        }
    }
}

fn turned(frame: &mut Frame, angle_rad: f64) {
    let turn = Rotation3::from_axis_angle(&Vector::z_axis(), angle_rad);
    for section in frame.sections.iter_mut().flatten() {
        section.position_m = turn * section.position_m;
        section.rotation = turn.matrix() * section.rotation;
    }
    frame.edges_m.iter_mut().flatten().flatten().for_each(|point| *point = turn * *point);
    frame.gauges_m.iter_mut().for_each(|point| *point = turn * *point);
    frame.lattice.clear();
}

/// The frames of a slowly rotating model change only at its edges, by an amount proportional to the rotation from frame to frame.
/// Coplanar or intersecting faces, such as those of lattice, body and latch, might flicker over their area at any angle. At a 25th of the
/// angle, the number of pixels that change by more than an eighth of the range is less than a tenth, and at most 2 % of those of the
/// model.
#[test]
fn slow_turns_change_frames_smoothly() {
    for name in ["folding_wing_constant", "flared_wing_tip"] {
        let share = |step_deg: f64| -> f64 {
            let recording =
                moved(recorded(shipped(name), 1), 9, |frame, i| turned(frame, step_deg.to_radians() * i as f64));
            let options = Options { frames_per_s: 10.0, speed: Some(1.0), follows: Some(false), ..options() };
            let film = film(&recording, &options);
            assert_eq!(film.times_s.len(), 9);
            let frames: Vec<Vec<u8>> = (0..9).map(|index| bare(&film, index).0).collect();
            let drawn = frames[0].chunks(3).filter(|rgb| **rgb != [255; 3]).count();
            let jumps = |pair: &[Vec<u8>]| {
                let differs = |(a, b): (&[u8], &[u8])| a.iter().zip(b).any(|(a, b)| a.abs_diff(*b) > 32);
                pair[0].chunks(3).zip(pair[1].chunks(3)).filter(|pair| differs(*pair)).count()
            };
            let most = frames.windows(2).map(jumps).max().unwrap();
            most as f64 / drawn as f64
        };
        let (slow, fast) = (share(0.02), share(0.5));
        assert!(slow < 0.02 && slow < 0.1 * fast, "{name}: {slow} and {fast}");
    }
}

/// A video has the number of frames for its duration at its speed; at the default speed it lasts about eight seconds.
#[test]
fn films_have_the_length_of_their_run() {
    let recording = recorded(shipped("folding_wing"), 400);
    let film_of = |options: Options| film(&recording, &options);
    let default = film_of(options());
    assert_eq!((default.speed, default.times_s.len(), default.times_s[240]), (0.05, 241, 0.4));
    let part = film_of(Options { span_s: [Some(0.1), Some(0.2)], speed: Some(0.1), ..options() });
    assert_eq!((part.times_s.len(), part.times_s[0], part.times_s[30]), (31, 0.1, 0.2));
    for (duration_s, speed) in [(0.4, 0.05), (8.0, 1.0), (60.0, 10.0), (1e-3, 0.001), (1e5, 20.0)] {
        assert_eq!(default_speed(duration_s), speed, "{duration_s} s");
    }
    let refused = |options: Options| Film::new(&PackedRun::for_film(&recording), &options).err().unwrap();
    for (options, needed) in [
        (Options { span_s: [Some(0.5), None], ..options() }, "--from 0.5: the run is from 0 to 0.4 s"),
        (Options { span_s: [None, Some(-1.0)], ..options() }, "--to -1: the run is from"),
        (Options { span_s: [Some(0.3), Some(0.2)], ..options() }, "--to 0.2: is before --from 0.3"),
        (Options { speed: Some(1e-5), ..options() }, "increase --speed (0.00001) or reduce --fps"),
    ] {
        let message = refused(options);
        assert!(message.contains(needed), "{message}");
    }
}

/// A flying model is followed by default and stays in the frame; a fixed one is framed with its whole motion.
#[test]
fn flying_machines_are_followed() {
    let away = moved(recorded(shipped("flying_wing"), 1), 5, |frame, i| {
        let shift = Vector::new(30.0 * i as f64, 0.0, -3.0 * i as f64);
        frame.sections.iter_mut().flatten().for_each(|section| section.position_m += shift);
        frame.edges_m.iter_mut().flatten().flatten().for_each(|point| *point += shift);
        frame.gauges_m.iter_mut().for_each(|point| *point += shift);
        frame.lattice.clear();
    });
    let followed = film(&away, &options());
    assert!(followed.follows);
    let boxes: Vec<[f64; 4]> =
        [0, 8, followed.times_s.len() - 1].map(|index| drawn_box(&bare(&followed, index).0, SIZE)).into();
    for found in &boxes {
        let off = found.iter().zip(&boxes[0]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off <= 2.0, "{boxes:?}");
    }
    assert!(boxes[0][1] - boxes[0][0] > 0.4 * f64::from(SIZE[0]), "{boxes:?}");
    assert!(!film(&recorded(shipped("folding_wing"), 3), &options()).follows);
}

/// Damaged data are errors, never a panic: missing numbers, references to missing bodies, descending times.
#[test]
fn damaged_pages_are_refused() {
    let packed = PackedRun::for_film(&recorded(shipped("folding_wing_in_tunnel"), 3));
    assert!(Run::read(&packed).is_ok());
    let with = |from: &str, to: &str| {
        assert!(packed.description.contains(from), "{from}");
        Run::read(&PackedRun { description: packed.description.replacen(from, to, 1), ..packed.clone() })
    };
    for (from, to) in [
        ("\"body\":0", "\"body\":99"),
        ("\"begins\":[", "\"begins\":[18446744073709551615,"),
        ("\"columns\":", "\"columns\":9"),
        ("\"winds\":", "\"winds\":7"),
        ("\"bodies\":[", "\"bodies\":[{\"rims\":[],\"places\":[],\"rigid\":false},"),
        ("\"name\"", "\"nam\""),
    ] {
        let message = with(from, to).unwrap_err();
        assert!(message.contains("damaged") && message.contains("write the page again"), "{message}");
    }
    let numbers = packed.numbers[..packed.numbers.len() / 8 * 4].to_owned();
    assert!(Run::read(&PackedRun { numbers, ..packed.clone() }).is_err());
}
