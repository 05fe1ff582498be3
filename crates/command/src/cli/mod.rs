//! The command line: arguments, exit codes, and one module per command.

mod air_summary;
mod assessment;
mod beam_sections;
mod beside;
mod branches;
mod calls;
mod campbell;
mod check;
mod choice;
mod compare;
mod completions;
mod constraint_summary;
mod examples;
mod failure;
mod fit;
mod flutter;
mod gradient;
mod grid;
mod help;
#[cfg(test)]
mod help_tests;
mod implausible;
mod joint_size;
mod latency;
mod lattice;
mod linearize;
mod live;
mod modes;
mod new;
mod notes;
mod number;
mod operating_points;
mod operating_table;
mod outlets;
mod package;
mod periodic;
mod periodic_tables;
mod pictures;
mod progress;
mod reading;
mod renamed;
mod render;
mod run;
mod settings;
mod shapes;
mod shipped;
mod simulate;
mod stability;
mod statics;
mod strains;
mod sweep;
mod tell;
mod timing;
mod trim;
mod version;
mod view;

pub use calls::{
    ModesOf, Packaging, SweepPlan, SweepRun, campbell, chosen, flutter_page, gradients, kinds, modes, modes_page,
    package, periodic_page, points, rest, summary, summary_json, text_with_values, write_page,
};

pub use failure::Failure;
pub use render::{Camera, Settings as FilmSettings, film_of_page};

use clap::{CommandFactory, Parser, Subcommand};
use foldwing_file as config;
use reading::{print, read_bytes, read_model, shown};
use std::ffi::OsString;
use std::path::Path;
use std::process::ExitCode;
use version::version;

/// Flexible multibody models with joints, such as folding wings, from short model files: FMUs, simulation, analysis
///
/// A model file (TOML) describes sections, bodies, joints, gauges and aerodynamics. Foldwing exports it as an FMU (FMI 2.0 or 3.0,
/// co-simulation and Model Exchange), and simulates and analyses it without an importer. No compiler is needed.
#[derive(Parser)]
#[command(name = "foldwing", version = version(), after_help = help::EXIT_CODES, after_long_help = help::ORDER_OF_WORK)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Write a model file to start from
    ///
    /// A wing of two bodies that unfolds and latches, named after the file, with every key explained, and the JSON schema that editors
    /// use for completion. --template selects an aircraft, a turbine, a wing in a wind tunnel or one with an aileron instead. Prints the
    /// next commands.
    New(new::Arguments),
    /// List the examples, or copy them into a folder
    ///
    /// The models, scripts and programs of the repository are contained in this command. Files that an example needs, such as polars and
    /// imported scripts, are copied with it. Notebooks are in the repository only.
    Examples(examples::Arguments),
    /// Export a model as an FMU
    ///
    /// The file is written completely or not at all; the same model, library and version give the same bytes. The default simulation is run
    /// to obtain the reference results in the FMU. The library is the one next to this executable, unless --library gives others, one for
    /// each platform.
    Package(package::Arguments),
    /// Simulate a model and write its outputs as CSV
    ///
    /// Writes the outputs, or the variables chosen by --variables, at the communication points. Optional: figures, an HTML page with an
    /// animation, VTK files for ParaView. A summary is printed to standard error; if no file is requested, it is the only result. If the
    /// simulation fails, tables and pictures contain the run up to that time.
    Simulate(simulate::Arguments),
    /// Show an animation of a simulation in the browser
    ///
    /// A model is simulated first, and the page is written to the current folder; a page written by `simulate --view` is opened.
    View(view::Arguments),
    /// Simulate in real time, interactively, in the browser
    ///
    /// Opens the page of `view` with a running simulation: run, pause, step or roll back on the time bar, change inputs and parameters with
    /// sliders, operate latches and failures with buttons, and pull on the model with the mouse through a spring. Only browsers on this
    /// computer can open the page, at the printed address. The command ends when the page is closed.
    Live(live::Arguments),
    /// Write a video of a simulation as a file: MP4, GIF or numbered images
    ///
    /// No browser and no display are needed: the model is drawn by this command, with the geometry and colours of the page of
    /// `simulate --view`. A model is simulated first. If the simulation fails, the video shows the run up to that time.
    Render(render::Arguments),
    /// Compare two tables over time within tolerances
    ///
    /// Compares two simulations, or a simulation and a measurement. Prints the largest difference of every common column, its time, and
    /// whether it is within the tolerance. The exit code is 5 if a column is outside its tolerance.
    Compare(compare::Arguments),
    /// Parameter sweep: simulate many variants of a model and write a row for each
    ///
    /// Variants run on several threads; the number of threads does not change the results. The same command resumes an interrupted sweep. A
    /// variant that fails has a row with its error message.
    Sweep(sweep::Arguments),
    /// Real-time test: measure the latency of single steps under a turbulent load
    ///
    /// For hardware-in-the-loop simulation. Prints median, 99 %, 99.9 % and maximum of the step times (wall and processor), and a
    /// histogram. `solver.mode = "real_time"` in the model bounds the cost of a step.
    Latency(latency::Arguments),
    /// Run an FMU of any tool (co-simulation of FMI 2.0 or 3.0) and write its outputs as CSV
    ///
    /// For FMUs of Foldwing the CSV file has the same bytes as that of `simulate`. Needs a build with the feature `import` (`make runner`).
    Run(run::Arguments),
    /// Check a model and summarise it
    ///
    /// Mass, centre of mass and inertia; static deflection under gravity and first natural frequencies; for each joint the torque needed
    /// against gravity, the torque of motor and spring, and whether the latch is reached. Warns of implausible values. Draws the model at
    /// its start angles with text characters. Lists bodies, masses, degrees of freedom, stations, joints, gauges, aerodynamics and
    /// variables; with --unknowns the number of unknowns per joint, compared with the conventional formulation.
    Check(check::Arguments),
    /// Compute the static equilibrium and print the deformed shape
    ///
    /// Equilibrium under gravity, loads and root motion: positions, rotations and strains along the bodies, joint angles with torques,
    /// gauges, gaps and forces of closed loops, tips, and the reaction on the root. Joints are locked or free according to their release
    /// inputs; an enabled latch that is reached on the load path closes.
    Static(statics::Arguments),
    /// Print natural frequencies and damping
    ///
    /// About the equilibrium or about the undeformed structure: frequencies, damping ratios and the kind of motion. Includes centrifugal
    /// stiffening and gyroscopic coupling of a rotating root.
    Modes(modes::Arguments),
    /// Compute the periodic steady state of a rotor and its Floquet modes
    ///
    /// With tilt, gravity or wind shear the steady state of a rotor is periodic in the azimuth. Prints means, ranges and harmonics of
    /// outputs over a revolution, and the Floquet modes about the periodic steady state, with frequencies in the fixed (non-rotating)
    /// frame. The shaft turns at constant speed.
    Periodic(periodic::Arguments),
    /// Tabulate power, thrust and loads of a rotor over wind speed, rotor speed and pitch
    ///
    /// Each point is the steady state in the rotating frame or, with tilt, gravity or shear, the periodic steady state: means and
    /// peak-to-peak values. --solve-for and --target find the pitch or the rotor speed at which an output has a given value, such as the
    /// pitch for rated power.
    OperatingPoints(operating_points::Arguments),
    /// Trim: solve for inputs or parameters that give outputs their target values at equilibrium
    ///
    /// For example, finds the wind direction and the thrust at which the forces on the root vanish. The equilibrium is computed at each
    /// iteration, with free hinges at their equilibrium angles. Prints the values as `--set` options for the other commands.
    Trim(trim::Arguments),
    /// Compute flutter and divergence speeds from the aeroelastic modes as a function of wind speed
    ///
    /// Modes about the equilibrium at each speed, with strip theory or a vortex lattice, are tracked from speed to speed, and the speeds at
    /// which they become unstable are refined. `--vary` repeats this over another quantity, such as the fold angle, the density or the
    /// stiffness of a latch. Latches keep their start state, open or closed.
    Flutter(flutter::Arguments),
    /// Compute derivatives of simulation results with respect to parameters of the model
    ///
    /// Computes exact derivatives of the time-discrete simulation, including latch closings and end stops: of outputs at given times, of
    /// largest values and means, of latch times and impulses, with respect to inputs, parameters and keys of the model file. If gradients do not cover a part
    /// of the model, the error names it.
    Gradient(gradient::Arguments),
    /// Identify parameters of the model from measurements
    ///
    /// Solves a nonlinear least-squares problem for measured and computed outputs over time, latch times and largest values, with the exact
    /// derivatives of `foldwing gradient`. Prints estimates within bounds, their standard errors, and the combinations of numbers that the
    /// measurements do not determine.
    Fit(Box<fit::Arguments>),
    /// Write a linear model from inputs to outputs
    ///
    /// Writes the matrices A, B, C, D about the start, an equilibrium or a state during a simulation, for NumPy or MATLAB, or as JSON.
    Linearize(linearize::Arguments),
    /// Print the JSON schema of model files, for autocompletion in editors
    #[command(after_long_help = help::SCHEMA)]
    Schema,
    /// Print a script that completes commands and options in a shell
    Completions(completions::Arguments),
}

/// Parts that `foldwing-import` shares with the other commands: arguments, choice of variables, files, figures, progress.
pub mod parts {
    pub use super::choice::{chosen, unknown};
    pub use super::grid::{Grid, grid_of};
    pub use super::number::six;
    pub use super::outlets::{Leftover, Mark, Outlets};
    pub use super::pictures::{check_figures, write_series};
    pub use super::progress::Progress;
    pub use super::reading::print;
    pub use super::simulate::{one_standard_output, read_inputs};
    pub use crate::cli::run::{Arguments as RunArguments, RunFmu};
}

/// Runs the command with the arguments of this process; `foldwing run` returns an error.
pub fn run() -> ExitCode {
    run_with(run::unavailable)
}

/// Runs the command with the arguments of this process, with `run_fmu` for `foldwing run`.
pub fn run_with(run_fmu: run::RunFmu) -> ExitCode {
    ExitCode::from(run_arguments(std::env::args_os(), None, run_fmu))
}

/// Runs the command given by `arguments`, which start with the name of the program, and returns its exit code. FMUs use `library` unless an
/// option names another one; without it, the library next to the executable.
pub fn run_as(arguments: impl IntoIterator<Item = OsString>, library: Option<&Path>) -> u8 {
    run_arguments(arguments, library, run::unavailable)
}

fn run_arguments(arguments: impl IntoIterator<Item = OsString>, library: Option<&Path>, run_fmu: run::RunFmu) -> u8 {
    match Arguments::try_parse_from(arguments) {
        Ok(arguments) => run_command(arguments.command, library, run_fmu),
        Err(error) => {
            tell::parse_error(&error);
            u8::try_from(error.exit_code()).unwrap_or(2)
        }
    }
}

fn run_command(command: Command, library: Option<&Path>, run_fmu: run::RunFmu) -> u8 {
    outlets::own_signals();
    let outcome = match command {
        Command::New(arguments) => new::run(&arguments),
        Command::Examples(arguments) => examples::run(&arguments),
        Command::Package(arguments) => package::run(&arguments, library),
        Command::Simulate(arguments) => simulate::run(&arguments),
        Command::View(arguments) => view::run(&arguments),
        Command::Live(arguments) => live::run(&arguments),
        Command::Render(arguments) => render::run(&arguments),
        Command::Compare(arguments) => compare::run(&arguments),
        Command::Sweep(arguments) => sweep::run(&arguments),
        Command::Latency(arguments) => latency::run(&arguments),
        Command::Run(arguments) => run_fmu(&arguments),
        Command::Check(arguments) => check::run(&arguments),
        Command::Static(arguments) => statics::run(&arguments),
        Command::Modes(arguments) => modes::run(&arguments),
        Command::Periodic(arguments) => periodic::run(&arguments),
        Command::OperatingPoints(arguments) => operating_points::run(&arguments),
        Command::Trim(arguments) => trim::run(&arguments),
        Command::Flutter(arguments) => flutter::run(&arguments),
        Command::Gradient(arguments) => gradient::run(&arguments),
        Command::Fit(arguments) => fit::run(&arguments),
        Command::Linearize(arguments) => linearize::run(&arguments),
        Command::Schema => print(&config::schema()),
        Command::Completions(arguments) => completions::run(&arguments, Arguments::command()),
    };
    match outcome {
        Ok(()) => 0,
        Err(failure) => {
            tell::failure(&failure);
            failure.exit_code()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The argument definitions are consistent.
    #[test]
    fn command_line_is_consistent() {
        Arguments::command().debug_assert();
    }
}
