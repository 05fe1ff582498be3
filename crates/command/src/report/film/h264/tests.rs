use super::*;
use sha2::{Digest, Sha256};

const SIZE: [u32; 2] = [70, 54];

/// Picture of a shaded disc that moves over fine stripes and a plain background.
fn scene(picture: usize) -> Vec<u8> {
    let [width, height] = SIZE.map(|length| length as usize);
    let pixel = |i: usize| {
        let (x, y) = (i % width, i / width);
        let away = (x as i32 - 20 - 3 * picture as i32).pow(2) + (y as i32 - 27).pow(2);
        match (away < 150, x < 30 && y > 40) {
            (true, _) => [(200 - away / 2) as u8, (20 + 5 * (x % 20)) as u8, (3 * y) as u8],
            (false, true) => [[0, 80, 255][(x + y) % 3]; 3],
            (false, false) => [255; 3],
        }
    };
    (0..width * height).flat_map(pixel).collect()
}

/// Codes of table 9-2, signs of table 9-3, and bytes that a NAL unit must not contain.
#[test]
fn codes_are_those_of_the_standard() {
    let bits = |fill: &dyn Fn(&mut Bits)| {
        let mut bits = Bits::default();
        fill(&mut bits);
        bits.unit(0x65)
    };
    assert_eq!(bits(&|bits| (0..5).for_each(|value| bits.ue(value))), [0x65, 0b1010_0110, 0b0100_0010, 0b1100_0000]);
    assert_eq!(bits(&|bits| [1, -1, 2].into_iter().for_each(|value| bits.se(value))), [0x65, 0b0100_1100, 0b1001_0000]);
    assert_eq!(bits(&|bits| bits.put(1, 32)), [0x65, 0, 0, 3, 0, 1, 0x80]);
    assert_eq!(bits(&|bits| bits.put(0, 32)), [0x65, 0, 0, 3, 0, 0, 0x80]);
}

/// The first example of residual blocks in Richardson (2003, section 6.4.12.2): the coefficients 0, 3, 0, 1, −1, −1, 0, 1, 0 … with no
/// coefficients in the neighbouring blocks are encoded as 000010001110010111101101.
#[test]
fn a_residual_block_has_its_known_bits() {
    let mut bits = Bits::default();
    let mut block = [0; 16];
    block[..8].copy_from_slice(&[0, 3, 0, 1, -1, -1, 0, 1]);
    assert_eq!(write(&mut bits, &block, Neighbours::Count(0)), 5);
    assert_eq!(bits.unit(0), [0, 0b0000_1000, 0b1110_0101, 0b1110_1101, 0x80]);
}

/// Transform, quantisation and their inverses reproduce a block within the quantiser step, 8 at QP 22, plus round-off.
#[test]
fn blocks_return_within_a_step() {
    let mut random = fastrand::Rng::with_seed(5);
    for _ in 0..200 {
        let block: Block = std::array::from_fn(|_| random.i32(-255..=255));
        let back = inverse(&restored(&quantised(&forward(&block), 3)));
        let off = block.iter().zip(&back).map(|(a, b)| (a - b).abs()).max().unwrap();
        assert!(off <= 16, "{off}");
    }
}

/// Every decoded picture is close to the original: errors do not accumulate from one picture to the next.
#[test]
fn pictures_stay_close() {
    let mut encoder = Encoder::new(SIZE, 100);
    for picture in 0..12 {
        let source = encoder.planes(&scene(picture));
        encoder.encode(&scene(picture));
        let pairs = source[0].samples.iter().zip(&encoder.restored[0].samples);
        let square: f64 = pairs.map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2)).sum();
        let noise_db = 10.0 * (255.0_f64.powi(2) * source[0].samples.len() as f64 / square).log10();
        assert!(noise_db > 38.0, "picture {picture}: {noise_db} dB");
    }
    // an unchanged picture takes a few bytes
    let still = encoder.encode(&scene(11)).bytes;
    let same = encoder.encode(&scene(11)).bytes;
    assert!(still.len() < 20 && same.len() < 20, "{} and {} bytes", still.len(), same.len());
}

/// The stream and the decoded pictures are bit-identical to those decoded by FFmpeg 8.0 (PyAV 18.1) on 2026-11-26.
#[test]
fn the_stream_is_the_one_that_another_decoder_has_decoded() {
    let mut encoder = Encoder::new(SIZE, 5);
    let (mut stream, mut shown) = (Sha256::new(), Sha256::new());
    for picture in 0..12 {
        let encoded = encoder.encode(&scene(picture));
        assert_eq!(encoded.stands_alone, picture % 5 == 0);
        stream.update(&encoded.bytes);
        encoder.restored.iter().for_each(|plane| shown.update(&plane.samples));
    }
    let text =
        |hash: Sha256| hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect::<String>()[..16].to_owned();
    assert_eq!([text(stream), text(shown)], ["419b9483cb9bd14e", "65d5bb6266c52958"]);
}
