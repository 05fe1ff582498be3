//! `--plot`, `--view` and `--vtk`: pictures of a run.

use crate::cli::Failure;
use crate::cli::beside;
use crate::cli::grid::Grid;
use crate::cli::outlets::{Mark, Outlets, Place};
use crate::report::Recording;
use crate::report::figure::{Figure, FigureError, SIZE, Sheet};
use crate::report::plots::{self, Measured, Series};
use crate::report::recording::FRAMES;
use crate::report::signals::Signals;
use crate::report::viewer::{Companion, PackedRun};
use crate::report::{number, viewer, vtk};
use foldwing_engine::plant::Plant;
use foldwing_fmi::interface::{Value, Variable};
use foldwing_recording::columns;
use std::path::{Path, PathBuf};

#[derive(clap::Args)]
pub struct PictureArguments {
    /// Folder for figures: fold angles and torques, tip positions, moment on the root, strains, aerodynamic force, energies, tip paths,
    /// shapes, and the variables named by `--variables`
    #[arg(long, value_name = "DIR")]
    pub plot: Option<PathBuf>,
    #[command(flatten)]
    pub sheets: SheetArguments,
    /// HTML page with an animation: one file, no network needed
    #[arg(long, value_name = "OUT.html")]
    pub view: Option<PathBuf>,
    /// Data to overlay on the page of `--view` and the figures of `--plot`; may be repeated: a table over time (.csv with a column
    /// `time`) as dots on the curves of the same names; on the page also another model (.toml), which is simulated at the same times, or
    /// another page of `--view` (.html)
    #[arg(long = "compare", value_name = "FILE")]
    pub beside: Vec<PathBuf>,
    /// Folder for VTK files over time, for ParaView: open `run.pvd`, which contains wing, joints, gauges, loads, surfaces and wake
    #[arg(long, value_name = "DIR")]
    pub vtk: Option<PathBuf>,
    /// Maximum number of frames of `--view` and `--vtk` after the first; a page that would exceed 10 MB has fewer frames
    #[arg(long, value_name = "N", default_value_t = FRAMES, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    pub frames: u64,
}

/// Format and size of figures, the same for `simulate` and `run`.
#[derive(clap::Args, Clone)]
pub struct SheetArguments {
    /// Width and height of the figures of `--plot` in pixels of 1/96 inch; below a width of 480 the layout is that of a journal
    /// column, with 8-point text: 321x220 is 85 mm wide
    #[arg(long, value_name = "WxH", default_value = "960x600", value_parser = size)]
    pub plot_size: [u32; 2],
    /// Pixels per inch of the PNG files of `--plot`
    #[arg(long, value_name = "N", default_value_t = 192, value_parser = clap::value_parser!(u16).range(24..=1200))]
    pub plot_dpi: u16,
    /// Formats of the figures of `--plot`, separated by commas
    #[arg(long, value_name = "FORMATS", value_delimiter = ',', default_value = "svg,png")]
    pub plot_format: Vec<Format>,
}

/// Format of a figure.
#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Format {
    /// Vector graphics for web pages and papers
    Svg,
    /// Pixels
    Png,
    /// Vector graphics for papers, with text as outlines
    Pdf,
}

/// Formats with their file extensions and marks.
const FORMATS: [(Format, &str, Mark); 3] =
    [(Format::Svg, "svg", Mark::SVG), (Format::Png, "png", Mark::PNG), (Format::Pdf, "pdf", Mark::PDF)];

impl SheetArguments {
    /// Default settings.
    pub const DEFAULT: Self = Self { plot_size: SIZE, plot_dpi: 192, plot_format: Vec::new() };

    fn sheet(&self) -> Sheet {
        Sheet { size: self.plot_size, scale: f32::from(self.plot_dpi) / 96.0 }
    }
}

/// Parses `WxH`.
fn size(text: &str) -> Result<[u32; 2], String> {
    let parsed = text.split_once(['x', 'X']).and_then(|(width, height)| {
        let [width, height]: [u32; 2] = [width.parse().ok()?, height.parse().ok()?];
        ((240..=6000).contains(&width) && (160..=6000).contains(&height)).then_some([width, height])
    });
    parsed.ok_or_else(|| "must be WIDTHxHEIGHT, 240x160 to 6000x6000, such as 960x600".to_owned())
}

impl PictureArguments {
    /// Returns whether any picture is requested.
    pub fn any(&self) -> bool {
        self.plot.is_some() || self.view.is_some() || self.vtk.is_some()
    }
}

/// Recorder of the pictures of a run in progress.
pub struct Pictures<'a> {
    wanted: &'a PictureArguments,
    /// Variables selected by the caller.
    series: Option<Series>,
    /// All recorded variables, for the page.
    signals: Option<Signals>,
    companions: Vec<Companion>,
    recording: Option<Recording>,
    steps: u64,
    view: Place,
}

impl<'a> Pictures<'a> {
    /// Prepares the pictures of a run; `recorded` are its recorded variables, `named` those selected by the caller. Creates the folders,
    /// checks their contents and reads the data to compare, so that errors in paths are reported before the run.
    pub fn new(
        wanted: &'a PictureArguments,
        grid: &Grid,
        recorded: &[&Variable],
        named: &[&Variable],
        outlets: &mut Outlets,
    ) -> Result<Self, Failure> {
        let steps = grid.steps;
        if let Some(path) = wanted.beside.first() {
            let shown = path.display();
            if wanted.view.is_none() && wanted.plot.is_none() {
                return Err(Failure::Usage(format!("--compare {shown}: needs --view or --plot")));
            }
            if wanted.view.is_none() && beside::runs(&wanted.beside)? > 1 {
                return Err(Failure::Usage(format!(
                    "--compare {shown}: only tables (.csv) can be shown in figures; add --view for models and pages"
                )));
            }
        }
        if let Some(folder) = &wanted.plot {
            check_figures(folder, outlets)?;
        }
        if let Some(folder) = &wanted.vtk {
            make_folder(folder)?;
            outlets.check(&folder.join("run.pvd"), &Mark::VTK)?;
            for name in vtk::SERIES {
                outlets.check(&folder.join(format!("{name}.pvd")), &Mark::VTK)?;
                outlets.check(&folder.join(format!("{name}_0000.vtu")), &Mark::VTK)?;
            }
        }
        let view = outlets.place_if(wanted.view.as_deref(), Mark::PAGE)?;
        let named = named.iter().map(|variable| (variable.name.as_str(), variable.unit()));
        let series = wanted.plot.as_ref().map(|_| Series::new(named, steps));
        let signals = wanted.view.as_ref().map(|_| Signals::new(columns(recorded.iter().copied()), steps));
        let companions = beside::companions(&wanted.beside, grid, wanted.frames)?;
        Ok(Self { wanted, series, signals, companions, recording: None, steps, view })
    }

    /// Records the plant at one of the `steps + 1` points of the run, with the values of the named variables.
    pub fn include(&mut self, plant: &Plant, values: impl Iterator<Item = Value>) {
        if !self.wanted.any() {
            return;
        }
        self.recording.get_or_insert_with(|| Recording::new(plant, self.steps, self.wanted.frames)).include(plant);
        let values: Vec<f64> = values.map(|value| number(&value)).collect();
        if let Some(signals) = &mut self.signals {
            signals.include(plant.time_s(), values.iter().copied());
        }
        if let Some(series) = &mut self.series {
            series.include(plant.time_s(), values);
        }
    }

    /// Writes the pictures, up to the time reached by the run.
    pub fn write(self, outlets: &mut Outlets) -> Result<(), Failure> {
        let Some(recording) = &self.recording else { return Ok(()) };
        let measured: Vec<Measured> = self.companions.iter().filter_map(measured).collect();
        if let Some(folder) = &self.wanted.plot {
            let figures = plots::figures(recording, &measured);
            if let Some(overview) = plots::overview(&recording.scene.name, &figures) {
                write_figure(folder, plots::OVERVIEW, &overview, &self.wanted.sheets, outlets)?;
            }
            for (stem, figure) in figures {
                write_figure(folder, stem, &figure, &self.wanted.sheets, outlets)?;
            }
        }
        if let (Some(folder), Some(series)) = (&self.wanted.plot, &self.series) {
            let figures = series.figures(&recording.scene.name, &measured, &plots::marks(recording));
            write_series(folder, figures, &self.wanted.sheets, outlets)?;
        }
        if let Some(signals) = &self.signals {
            let runs = beside::runs(&self.wanted.beside)?;
            let run = PackedRun::new(recording, signals, runs);
            self.view.fill(viewer::page(&recording.scene.name, &run, &self.companions).as_bytes())?;
        }
        if let Some(folder) = &self.wanted.vtk {
            vtk::files(recording, |name, text| outlets.place(&folder.join(name), Mark::VTK)?.fill(text.as_bytes()))?;
        }
        Ok(())
    }
}

/// Converts a table to the form for figures.
fn measured(companion: &Companion) -> Option<Measured> {
    match companion {
        Companion::Table { label, table } => {
            Some(Measured { label: label.clone(), names: table.names.clone(), rows: table.rows.clone() })
        }
        Companion::Run { .. } => None,
    }
}

/// Creates a folder for figures. Fails before the run if files with the names of the figures exist that Foldwing did not write.
pub fn check_figures(folder: &Path, outlets: &Outlets) -> Result<(), Failure> {
    make_folder(folder)?;
    let series = (1..).map(|n| format!("outputs_{n}")).take_while(|name| folder.join(format!("{name}.svg")).exists());
    for name in plots::NAMES.into_iter().chain([plots::OVERVIEW]).map(str::to_owned).chain(series) {
        for (_, ending, mark) in FORMATS {
            outlets.check(&folder.join(format!("{name}.{ending}")), &mark)?;
        }
    }
    Ok(())
}

/// Like [`check_figures`], for one figure.
pub(super) fn check_figure(folder: &Path, stem: &str, outlets: &Outlets) -> Result<(), Failure> {
    make_folder(folder)?;
    FORMATS.iter().try_for_each(|(_, ending, mark)| outlets.check(&folder.join(format!("{stem}.{ending}")), mark))
}

fn make_folder(folder: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).map_err(|error| Failure::writing(&folder.display().to_string(), &error))
}

/// Writes the figures of variables as `outputs_1.svg`, `outputs_1.png` and so on.
pub fn write_series(
    folder: &Path,
    figures: Vec<Figure>,
    sheets: &SheetArguments,
    outlets: &mut Outlets,
) -> Result<(), Failure> {
    let mut figures = figures.into_iter().enumerate();
    figures.try_for_each(|(i, figure)| write_figure(folder, &format!("outputs_{}", i + 1), &figure, sheets, outlets))
}

/// Writes a figure in the requested formats: `stem.svg`, `stem.png`, `stem.pdf`.
pub(super) fn write_figure(
    folder: &Path,
    stem: &str,
    figure: &Figure,
    sheets: &SheetArguments,
    outlets: &mut Outlets,
) -> Result<(), Failure> {
    let drawn = |error: FigureError| Failure::Files(format!("{}: {error}", folder.display()));
    for (format, ending, mark) in FORMATS {
        if !sheets.plot_format.contains(&format) {
            continue;
        }
        let bytes = match format {
            Format::Svg => figure.svg(sheets.sheet()).map_err(drawn)?.into_bytes(),
            Format::Png => figure.png(sheets.sheet()).map_err(drawn)?,
            Format::Pdf => figure.pdf(sheets.sheet()).map_err(drawn)?,
        };
        outlets.place(&folder.join(format!("{stem}.{ending}")), mark)?.fill(&bytes)?;
    }
    Ok(())
}
