//! `foldwing render`: a video of a run as a file, without a browser or a display.

use crate::cli::grid::{GridArguments, grid_of};
use crate::cli::outlets::{Force, Mark, Outlets, Place};
use crate::cli::progress::Progress;
use crate::cli::settings::plant_with;
use crate::cli::simulate::{feed, one_standard_input, read_inputs};
use crate::cli::{Failure, print, read_model};
use crate::report::Recording;
use crate::report::film::{Film, Format, MAXIMUM_FRAMES, Options, View, default_speed, encode, frame_count};
use crate::report::viewer::{PackedRun, run_of_page};
use clap::ValueEnum;
use clap::builder::NonEmptyStringValueParser;
use foldwing_fmi::interface::Interface;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::sync::mpsc;
use std::time::Instant;

/// Minimum number of frames recorded of a run, so that events between the frames of the video are not missed.
const RECORDED_FRAMES: u64 = 600;
/// Maximum number of frames recorded.
const MAXIMUM_RECORDED_FRAMES: u64 = 4_000;

#[derive(clap::Args)]
#[command(after_long_help = crate::cli::help::RENDER)]
pub struct Arguments {
    /// Model file, which is simulated first; or a page of `simulate --view`
    #[arg(value_name = "MODEL_OR_PAGE")]
    run: PathBuf,
    /// Video to write: .mp4 (H.264), .gif, or .png for one numbered file per frame
    #[arg(short = 'o', long, visible_alias = "output", value_name = "OUT")]
    video: PathBuf,
    /// Width and height in pixels [default: 1280x720; GIF: 800x450]
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<[u32; 2]>,
    /// Frames per second [default: 30; GIF: 25]
    #[arg(long, value_name = "N", value_parser = frames_per_s)]
    fps: Option<f64>,
    /// Seconds of the run per second of the video, such as 0.05 for slow motion [default: the video lasts about 8 s]
    #[arg(long, value_name = "X", value_parser = speed)]
    speed: Option<f64>,
    /// Camera: `follow` moves with the model, `fixed` frames the whole motion; `iso`, `front`, `side`, `top` select the view;
    /// one of each, separated by a comma [default: iso; follow if the model flies, else fixed]
    #[arg(long, value_name = "CAMERA", value_delimiter = ',')]
    camera: Vec<Camera>,
    /// Simulated time in s at which the video starts [default: the start of the run]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    from: Option<f64>,
    /// Simulated time in s at which the video ends [default: the end of the run]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    to: Option<f64>,
    /// Inputs over time, as in `simulate`
    #[arg(long, value_name = "IN.csv")]
    inputs: Option<PathBuf>,
    /// Start value of an input or parameter; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = NonEmptyStringValueParser::new())]
    settings: Vec<String>,
    #[command(flatten)]
    grid: GridArguments,
    #[command(flatten)]
    force: Force,
    /// Print the summary as JSON on standard output, for programs: frames, speed, camera, times, written files
    #[arg(long)]
    json: bool,
    /// Print no summary
    #[arg(short, long)]
    quiet: bool,
}

/// Motion of the camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Camera {
    /// Moves with the model
    Follow,
    /// Fixed; shows the whole motion
    Fixed,
    /// Oblique view
    Iso,
    /// x to the right, z up
    Front,
    /// y to the right, z up
    Side,
    /// x to the right, y up
    Top,
}

impl Camera {
    /// Returns the camera with this name.
    ///
    /// # Errors
    /// An unknown name; the message lists the valid ones.
    pub fn of(word: &str) -> Result<Self, Failure> {
        let words = Self::value_variants().iter().filter_map(ValueEnum::to_possible_value);
        let words: Vec<String> = words.map(|value| value.get_name().to_owned()).collect();
        <Self as ValueEnum>::from_str(word, false)
            .map_err(|_| Failure::Usage(format!("--camera {word}: must be {}", words.join(", "))))
    }
}

/// Parses `WxH`.
fn size(text: &str) -> Result<[u32; 2], String> {
    let parsed = text.split_once(['x', 'X']).and_then(|(width, height)| {
        let size: [u32; 2] = [width.parse().ok()?, height.parse().ok()?];
        size.iter().all(|length| (64..=4096).contains(length)).then_some(size)
    });
    parsed.ok_or_else(|| "must be WIDTHxHEIGHT, 64x64 to 4096x4096, such as 1920x1080".to_owned())
}

fn within(text: &str, least: f64, most: f64) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|number| (least..=most).contains(number));
    number.ok_or_else(|| format!("must be a number from {least} to {most}"))
}

fn frames_per_s(text: &str) -> Result<f64, String> {
    within(text, 1.0, 240.0)
}

fn speed(text: &str) -> Result<f64, String> {
    within(text, 1e-6, 1e6)
}

/// View and motion of the camera, each given at most once.
fn camera(given: &[Camera]) -> Result<(View, Option<bool>), Failure> {
    let (mut view, mut follows) = (None, None);
    for camera in given {
        let doubled = match camera {
            Camera::Follow => follows.replace(true).is_some(),
            Camera::Fixed => follows.replace(false).is_some(),
            Camera::Iso => view.replace(View::Iso).is_some(),
            Camera::Front => view.replace(View::Front).is_some(),
            Camera::Side => view.replace(View::Side).is_some(),
            Camera::Top => view.replace(View::Top).is_some(),
        };
        if doubled {
            return Err(Failure::Usage(
                "--camera: at most one of `follow` and `fixed`, and one of `iso`, `front`, `side`, `top`".to_owned(),
            ));
        }
    }
    Ok((view.unwrap_or(View::Iso), follows))
}

/// Optional settings of a video.
#[derive(Debug, Clone, Default)]
pub struct Settings {
    /// Width and height in pixels.
    pub size: Option<[u32; 2]>,
    /// Frames per second.
    pub frames_per_s: Option<f64>,
    /// Seconds of the run per second of the video.
    pub speed: Option<f64>,
    /// View and motion of the camera.
    pub camera: Vec<Camera>,
    /// First and last time in s.
    pub span_s: [Option<f64>; 2],
}

impl Settings {
    /// Returns the format and settings of a file.
    fn of(&self, video: &Path) -> Result<(Format, Options), Failure> {
        let refused = |cause: String| Failure::Usage(format!("--video {}: {cause}", video.display()));
        let format = Format::of(video).map_err(refused)?;
        let (default_size, default_per_s) = match format {
            Format::Gif => ([800, 450], 25.0),
            Format::Mp4 | Format::Png => ([1280, 720], 30.0),
        };
        let (view, follows) = camera(&self.camera)?;
        let (size, frames_per_s) = (self.size.unwrap_or(default_size), self.frames_per_s.unwrap_or(default_per_s));
        format.check(size, frames_per_s).map_err(Failure::Usage)?;
        Ok((format, Options { size, frames_per_s, speed: self.speed, view, follows, span_s: self.span_s }))
    }
}

/// Writes a video of the run in a page of `simulate --view`, as the command does, and returns the output of `--json`. `drawn` is called with
/// the number of finished frames and the total.
///
/// # Errors
/// As for the command, and errors of `drawn`.
pub fn film_of_page(
    page: &str,
    video: &Path,
    settings: &Settings,
    force: bool,
    mut drawn: impl FnMut(usize, usize) -> Result<(), Failure>,
) -> Result<serde_json::Value, Failure> {
    let check = |text: String, parsed: Result<(), String>, option: &str| {
        parsed.map_err(|cause| Failure::Usage(format!("{option} {text}: {cause}")))
    };
    if let Some([width, height]) = settings.size {
        let text = format!("{width}x{height}");
        check(text.clone(), size(&text).map(|_| ()), "--size")?;
    }
    for (value, parse, option) in [
        (settings.frames_per_s, frames_per_s as fn(&str) -> Result<f64, String>, "--fps"),
        (settings.speed, speed, "--speed"),
    ] {
        if let Some(value) = value {
            check(value.to_string(), parse(&value.to_string()).map(|_| ()), option)?;
        }
    }
    let (format, options) = settings.of(video)?;
    let mut outlets = Outlets::new(force, []);
    let target = Target::new(video, format, &mut outlets)?;
    let packed = run_of_page(page).map_err(|cause| Failure::Refused(format!("the page {cause}")))?;
    let film = Film::new(&packed, &options).map_err(Failure::Usage)?;
    let (began, count) = (Instant::now(), film.times_s.len());
    write(&film, &options, (format, target), &mut outlets, |done| drawn(done, count))?;
    Ok(summary(&film, &options, (began.elapsed().as_secs_f64(), &outlets)))
}

/// Simulates a model, or reads a page, and writes the video.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let settings = Settings {
        size: arguments.size,
        frames_per_s: arguments.fps,
        speed: arguments.speed,
        camera: arguments.camera.clone(),
        span_s: [arguments.from, arguments.to],
    };
    let (format, options) = settings.of(&arguments.video)?;
    one_standard_input([Some(arguments.run.as_path()), arguments.inputs.as_deref()])?;
    let read = [Some(arguments.run.as_path()), arguments.inputs.as_deref()].into_iter().flatten();
    let mut outlets = Outlets::new(arguments.force.force, read);
    let target = Target::new(&arguments.video, format, &mut outlets)?;
    let (packed, outcome) = packed(arguments, &options)?;
    let film = Film::new(&packed, &options).map_err(Failure::Usage)?;
    let began = Instant::now();
    let mut progress = Progress::of("frames", film.times_s.len() as u64);
    write(&film, &options, (format, target), &mut outlets, |done| {
        progress.at(done as u64);
        Ok(())
    })?;
    drop(progress);
    outcome?;
    report(arguments, &film, &options, (began.elapsed().as_secs_f64(), &outlets))
}

/// Destination of the video.
enum Target {
    File(Place),
    /// Numbered files; the number precedes the extension.
    Numbered(PathBuf),
}

impl Target {
    /// Fails before the run if files exist there that Foldwing did not write.
    fn new(video: &Path, format: Format, outlets: &mut Outlets) -> Result<Self, Failure> {
        match format {
            Format::Mp4 => Ok(Self::File(outlets.place(video, Mark::MP4)?)),
            Format::Gif => Ok(Self::File(outlets.place(video, Mark::GIF)?)),
            Format::Png => {
                outlets.check(&numbered(video, 0), &Mark::PNG)?;
                Ok(Self::Numbered(video.to_owned()))
            }
        }
    }
}

/// Path of a frame: `wing.png` becomes `wing_00001.png` for the first.
fn numbered(path: &Path, index: usize) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}_{:05}.png", index + 1))
}

/// Returns the run of a page, or of a simulated model with the error that ended it.
fn packed(arguments: &Arguments, options: &Options) -> Result<(PackedRun, Result<(), Failure>), Failure> {
    let run = &arguments.run;
    let extension = run.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    match extension.as_str() {
        "html" | "htm" => {
            let simulated = arguments.inputs.is_some() || !arguments.settings.is_empty();
            if simulated || arguments.grid.given().iter().any(Option::is_some) {
                return Err(Failure::Usage(format!(
                    "{}: a page is not simulated again: --inputs, --set, --step, --start and --stop need a model file",
                    run.display()
                )));
            }
            let text = std::fs::read_to_string(run)
                .map_err(|error| Failure::Files(format!("{}: cannot be read: {error}", run.display())))?;
            let packed = run_of_page(&text).map_err(|cause| Failure::Refused(format!("{}: {cause}", run.display())))?;
            Ok((packed, Ok(())))
        }
        "csv" => Err(Failure::Usage(format!(
            "{}: a table has no geometry to draw; name the model, or a page of `simulate --view`",
            run.display()
        ))),
        _ => simulated(arguments, options),
    }
}

/// Simulates and records a model, up to an error if there is one.
fn simulated(arguments: &Arguments, options: &Options) -> Result<(PackedRun, Result<(), Failure>), Failure> {
    let (machine, _) = read_model(&arguments.run)?;
    let experiment = &machine.experiment;
    let grid = grid_of(&arguments.grid, experiment.start_time_s, experiment.stop_time_s, experiment.step_s)?;
    let interface = Interface::new(&machine);
    let inputs = arguments.inputs.as_ref().map(|path| read_inputs(path, interface.variables())).transpose()?;
    let mut plant = plant_with(machine, &interface, &arguments.settings)?;
    let failed = |error: foldwing_engine::plant::PlantError| Failure::Simulation(error.to_string());
    let span_s = [options.span_s[0].unwrap_or(grid.start_s), options.span_s[1].unwrap_or(grid.stop_s)];
    for (option, time_s) in [("--from", span_s[0]), ("--to", span_s[1])] {
        if !(grid.start_s..=grid.stop_s).contains(&time_s) {
            let (start_s, stop_s) = (grid.start_s, grid.stop_s);
            return Err(Failure::Usage(format!("{option} {time_s}: the run is from {start_s} to {stop_s} s")));
        }
    }
    let frames = recorded_frames(span_s[1] - span_s[0], grid.stop_s - grid.start_s, options);
    feed(inputs.as_ref(), &interface, &mut plant, grid.start_s)?;
    plant.initialize(grid.start_s).map_err(failed)?;
    let mut recording = Recording::new(&plant, grid.steps, frames);
    recording.include(&plant);
    let mut progress = Progress::of("time", grid.steps);
    let mut outcome = Ok(());
    for point in 1..=grid.steps {
        feed(inputs.as_ref(), &interface, &mut plant, grid.time_s(point - 1))?;
        if let Err(error) = plant.step(grid.time_s(point)) {
            outcome = Err(failed(error)); // the video shows the run up to the error
            break;
        }
        recording.include(&plant);
        progress.at(point);
        if grid.time_s(point - 1) > span_s[1] {
            break; // later states are not shown
        }
    }
    Ok((PackedRun::for_film(&recording), outcome))
}

/// Number of frames to record: one for every frame of the video as far as memory allows.
fn recorded_frames(shown_s: f64, duration_s: f64, options: &Options) -> u64 {
    let speed = options.speed.unwrap_or_else(|| default_speed(shown_s));
    let frames = frame_count(shown_s, options.frames_per_s, speed).min(MAXIMUM_FRAMES as f64);
    let wanted = frames * duration_s / shown_s.max(1e-3 * duration_s);
    (wanted.ceil() as u64).clamp(RECORDED_FRAMES, MAXIMUM_RECORDED_FRAMES)
}

fn write(
    film: &Film,
    options: &Options,
    (format, target): (Format, Target),
    outlets: &mut Outlets,
    mut drawn: impl FnMut(usize) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let settings = (format, options.frames_per_s);
    match target {
        Target::File(place) => {
            let mut bytes = Vec::new();
            let keep = |_: Option<usize>, file: Vec<u8>| {
                bytes = file;
                Ok(())
            };
            encode(film, settings, keep, drawn)?;
            place.fill(&bytes)
        }
        Target::Numbered(path) => {
            // the thread that runs the command writes the files, not those that draw
            let (send, received) = mpsc::channel();
            let keep = |index: Option<usize>, file: Vec<u8>| {
                let _ = send.send((index.unwrap_or(0), file)); // the receiver outlives the senders
                Ok(())
            };
            let mut store = |done: usize| {
                for (index, file) in received.try_iter() {
                    outlets.place(&numbered(&path, index), Mark::PNG)?.fill(&file)?;
                }
                drawn(done)
            };
            encode(film, settings, keep, &mut store)?;
            store(film.times_s.len())
        }
    }
}

/// The video as JSON.
fn summary(film: &Film, options: &Options, (took_s, outlets): (f64, &Outlets)) -> serde_json::Value {
    let (frames, [width, height]) = (film.times_s.len(), options.size);
    json!({
        "from_s": film.times_s[0],
        "to_s": film.times_s[frames - 1],
        "speed": film.speed,
        "camera": if film.follows { "follow" } else { "fixed" },
        "frames": frames,
        "width": width,
        "height": height,
        "frames_per_s": options.frames_per_s,
        "length_s": frames as f64 / options.frames_per_s,
        "elapsed_s": took_s,
        "files": outlets.files(),
    })
}

fn report(
    arguments: &Arguments,
    film: &Film,
    options: &Options,
    (took_s, outlets): (f64, &Outlets),
) -> Result<(), Failure> {
    let frames = film.times_s.len();
    let [width, height] = options.size;
    if !arguments.quiet {
        if !arguments.json {
            eprintln!(
                "{} to {} s at --speed {} with --camera {}: {frames} frames of {width}x{height} in {took_s:.2} s, {:.2} s at {} per second",
                film.times_s[0],
                film.times_s[frames - 1],
                film.speed,
                if film.follows { "follow" } else { "fixed" },
                frames as f64 / options.frames_per_s,
                options.frames_per_s
            );
        }
        outlets.report();
    }
    if arguments.json {
        return print(&format!("{:#}", summary(film, options, (took_s, outlets))));
    }
    Ok(())
}
