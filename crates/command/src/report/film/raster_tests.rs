use super::*;

const SIZE: [u32; 2] = [64, 48];

fn corner(x: f64, y: f64, near: f64, rgb: [f32; 3]) -> Corner {
    Corner { x, y, near, rgb }
}

fn empty() -> Raster {
    let mut raster = Raster::new(SIZE);
    raster.clear([0.0; 3]);
    raster
}

fn pixel(raster: &Raster, x: usize, y: usize) -> [u8; 3] {
    let first = 3 * (y * SIZE[0] as usize + x);
    raster.pixels()[first..first + 3].try_into().unwrap()
}

/// The nearer face covers the other, in any drawing order; the inverse distance is interpolated over a sloping face.
#[test]
fn nearer_faces_cover() {
    let (red, blue) = ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    let flat = [corner(0.0, 0.0, 0.5, red), corner(64.0, 0.0, 0.5, red), corner(32.0, 48.0, 0.5, red)];
    // from far on the left to near on the right: 0.5 at x = 32
    let sloping = [corner(0.0, 0.0, 0.25, blue), corner(64.0, 0.0, 0.75, blue), corner(32.0, 48.0, 0.5, blue)];
    for order in [[flat, sloping], [sloping, flat]] {
        let mut raster = empty();
        order.into_iter().for_each(|face| raster.triangle(face, Ink::Solid));
        for x in [10, 20, 30] {
            assert_eq!(pixel(&raster, x, 4), [255, 0, 0], "{x}");
            assert_eq!(pixel(&raster, 63 - x, 4), [0, 0, 255], "{x}");
        }
    }
}

/// Of two coplanar faces, also with round-off and with opposite orientation, the one drawn first is visible everywhere.
#[test]
fn faces_in_one_plane_do_not_mix() {
    let near = |x: f64, y: f64| 0.3 + 0.001 * x + 0.002 * y;
    let at = |x: f64, y: f64, rgb| corner(x, y, near(x, y), rgb);
    let mut raster = empty();
    let (red, blue) = ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    raster.triangle([at(-3.3, 0.1, red), at(70.7, 1.9, red), at(31.1, 90.3, red)], Ink::Solid);
    raster.triangle([at(10.1, 5.3, blue), at(20.7, 40.9, blue), at(55.3, 9.1, blue)], Ink::Solid);
    raster.triangle([at(12.9, 2.3, blue), at(50.7, 8.9, blue), at(25.3, 39.1, blue)], Ink::Solid);
    assert!(raster.pixels().chunks(3).all(|rgb| rgb[2] == 0), "blue shows through");
    assert_eq!(pixel(&raster, 30, 20), [255, 0, 0]);
}

/// Two triangles that form a square cover each sample once; the covered area of pixels at the edges is correct within a quarter
/// each.
#[test]
fn coverage_is_the_area() {
    let white = [1.0; 3];
    let corners = [(5.3, 7.9), (49.6, 12.2), (41.1, 41.7), (9.8, 38.4)].map(|(x, y)| corner(x, y, 1.0, white));
    let [a, b, c, d] = corners;
    let mut raster = empty();
    raster.triangle([a, b, c], Ink::Glass(0.5));
    raster.triangle([a, c, d], Ink::Glass(0.5));
    let red: Vec<f64> = raster.pixels().chunks(3).map(|rgb| f64::from(rgb[0]) / 128.0).collect();
    assert!(red.iter().all(|share| *share <= 1.0), "a sample is covered twice");
    let twice = |a: Corner, b: Corner| a.x * b.y - b.x * a.y;
    let area = 0.5 * (twice(a, b) + twice(b, c) + twice(c, d) + twice(d, a));
    // 150 pixels on the edges, each with an error below a quarter, of either sign
    let off = red.iter().sum::<f64>() - area;
    assert!(off.abs() < 150.0_f64.sqrt(), "{off} of {area}");
}

/// A shadow darkens a pixel once, and only if its surface is behind the shadow in depth; triangles with NaN vertices are omitted.
#[test]
fn shadows_darken_once() {
    let mut raster = Raster::new(SIZE);
    raster.clear([1.0; 3]);
    let all = [
        corner(-100.0, -100.0, 1.0, [0.0; 3]),
        corner(300.0, -100.0, 1.0, [0.0; 3]),
        corner(0.0, 300.0, 1.0, [0.0; 3]),
    ];
    raster.triangle(all, Ink::Shadow(0.2));
    raster.triangle(all, Ink::Shadow(0.2));
    assert_eq!(pixel(&raster, 30, 20), [204; 3]);
    let broken =
        [corner(f64::NAN, 0.0, 9.0, [0.5; 3]), corner(9.0, 0.0, 9.0, [0.5; 3]), corner(0.0, 9.0, 9.0, [0.5; 3])];
    raster.triangle(broken, Ink::Solid);
    let huge =
        [corner(-1e300, 0.0, 9.0, [0.5; 3]), corner(1e300, 0.0, 9.0, [0.5; 3]), corner(0.0, 1e300, 9.0, [0.5; 3])];
    raster.triangle(huge, Ink::Solid);
    raster.line([corner(5.0, f64::INFINITY, 9.0, [0.5; 3]), corner(9.0, 0.0, 9.0, [0.5; 3])], 1.0, Ink::Solid);
    assert_eq!(pixel(&raster, 30, 20), [204; 3]);
}
