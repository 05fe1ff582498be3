//! Texts below the options in `foldwing --help` and `foldwing COMMAND --help`. A test parses every command line in them.

macro_rules! exit_codes {
    () => {
        "\
Exit codes:
  0  done
  1  a file has invalid content: model, inputs, library or FMU
  2  the command line is invalid, including unknown names in --variables and --set
  3  the simulation failed (the CSV has the rows up to that time), or there is no equilibrium or
     linear model
  4  a file could not be read or written
  5  `compare`: the tables differ by more than the tolerance"
    };
}

/// Text below `foldwing -h`.
pub(super) const EXIT_CODES: &str = exit_codes!();

/// Text below `foldwing --help`: the order of work, then the exit codes.
pub(super) const ORDER_OF_WORK: &str = concat!(
    "\
The usual order of work, from a model file to its FMU:
  foldwing new wing.toml                          a starter with two bodies, every key explained
  foldwing check wing.toml                        a check and a summary: masses, joints, variables
  foldwing simulate wing.toml --csv wing.csv      a simulation
  foldwing view wing.toml                         an animation in the browser
  foldwing static wing.toml                       its static equilibrium under gravity and loads
  foldwing modes wing.toml                        natural frequencies about that state
  foldwing flutter goland_wing.toml --wind-m-s 50:200:16
                                                  flutter and divergence speeds
  foldwing sweep wing.toml --vary fold.start_angle=0.5:2:16 --output sweep.csv
                                                  many variants, a row for each
  foldwing linearize wing.toml -o wing.npz        A, B, C, D for a controller
  foldwing package wing.toml -o Wing.fmu          the FMU
  foldwing package --help                         options and examples of a command

Errors in a file or on the command line are reported with their location and the allowed values.
Messages go to standard error, in colour if it is a terminal and NO_COLOR is not set. If it is a
terminal, work that lasts more than half a second shows its progress there, with the time left.

",
    exit_codes!()
);

pub(super) const NEW: &str = "\
Examples:
  foldwing new wing.toml
  foldwing new wing.toml --force
  foldwing new second.toml --no-schema
  foldwing new plane.toml --template aircraft
  foldwing new rotor.toml --template turbine";

pub(super) const EXAMPLES: &str = "\
Examples:
  foldwing examples
  foldwing examples models
  foldwing examples -o examples
  foldwing examples turbine/nrel_5mw_wind.toml goland_wing.toml -o try";

pub(super) const PACKAGE: &str = "\
Examples:
  foldwing package wing.toml -o Wing.fmu
  foldwing package wing.toml -o Wing.fmu --linear
  foldwing package wing.toml -o Wing.fmu --linear=0.3 --no-reference
  foldwing package wing.toml -o Wing.fmu --library libfoldwing_fmu.so --library foldwing_fmu.dll
  foldwing package wing.toml -o Wing.fmu --interface cs,me
  foldwing package wing.toml -o Wing.fmu --fmi 3
  foldwing package wing.toml -o Wing.fmu --ssp wing.ssp
  foldwing package wing.toml -o Wing.fmu --cross-check results
  foldwing package wing.toml --description-only";

pub(super) const SIMULATE: &str = "\
Examples:
  foldwing simulate wing.toml
  foldwing simulate wing.toml --csv wing.csv
  foldwing simulate wing.toml --csv - --variables fold.angle,tip.position.z --stop 0.2
  foldwing simulate wing.toml --csv fold.csv --variables \"fold.*\" --set fold.start_angle=\"90 deg\"
  foldwing simulate wing.toml --csv wing.csv --set fold.start_angle=1.5 --set fold.latch_enable=0
  foldwing simulate wing.toml --csv - --variables tip.position --set gravity=0,0,-1.62
  foldwing simulate wing.toml --csv wing.csv --inputs commands.csv
  foldwing simulate wing.toml --json
  foldwing simulate wing.toml --plot figures --view wing.html --vtk vtk
  foldwing simulate wing.toml --view wing.html --compare measured.csv --compare stiffer.toml
  foldwing simulate wing.toml --csv wing.csv --strains strains.csv --profile cost.json

A file of inputs has a column `time` (s, ascending) and columns named after inputs; lines that
start with # are comments:
  time, fold.angle_command, fold.release
  0.0,  0.0,          0
  0.1,  0.0,          1";

pub(super) const SWEEP: &str = "\
Examples:
  foldwing sweep wing.toml --vary fold.start_angle=1:3:21 --vary fold.release=0,1 --output grid.csv
  foldwing sweep wing.toml --vary file:body.inner.elements=2,4,8 --variables tip.position.z -o m.csv
  foldwing sweep wing.toml --samples samples.csv --output results.csv --view results.html";

pub(super) const LATENCY: &str = "\
Examples:
  foldwing latency wing.toml --steps 1000
  foldwing latency wing.toml --steps 1000 --step 1e-3 --turbulence 0.1 --seed 7
  foldwing latency wing.toml --steps 1000 --paced";

pub(super) const RUN: &str = "\
Examples:
  foldwing run Wing.fmu
  foldwing run Wing.fmu --csv wing.csv
  foldwing run Wing.fmu --list-variables
  foldwing run Wing.fmu --csv - --set \"fold.start_angle=90 deg\" --variables fold.angle --stop 0.2
  foldwing run Wing.fmu --csv wing.csv --inputs commands.csv --plot figures --log";

pub(super) const VIEW: &str = "\
Examples:
  foldwing view wing.toml
  foldwing view wing.toml --set fold.start_angle=\"90 deg\" --output half.html
  foldwing view wing.toml --compare stiffer.toml
  foldwing view wing.html";

pub(super) const LIVE: &str = "\
Examples:
  foldwing live wing.toml
  foldwing live wing.toml --speed 0.1 --set fold.start_angle=\"90 deg\"
  foldwing live wing.toml --compare stiffer.toml
  foldwing live wing.toml --no-browser --port 8000";

pub(super) const RENDER: &str = "\
Examples:
  foldwing render wing.toml --video wing.mp4
  foldwing render wing.toml --video wing.mp4 --size 1920x1080 --camera follow,side --speed 0.02
  foldwing render wing.html --video wing.gif --from 0.1 --to 0.2
  foldwing render wing.toml --video pictures/wing.png --fps 10 --set fold.start_angle=\"90 deg\"";

pub(super) const COMPARE: &str = "\
Examples:
  foldwing compare wing.csv wing.csv
  foldwing compare wing.csv measured.csv --variables fold.angle --tolerance fold.angle=5
  foldwing compare wing.csv measured.csv --variables \"fold.*\" --rtol 2 --json";

pub(super) const COMPLETIONS: &str = "\
Examples:
  foldwing completions bash > ~/.local/share/bash-completion/completions/foldwing
  foldwing completions zsh > ~/.zfunc/_foldwing
  foldwing completions fish > ~/.config/fish/completions/foldwing.fish
  foldwing completions powershell >> $PROFILE";

pub(super) const CHECK: &str = "\
Examples:
  foldwing check wing.toml
  foldwing check wing.toml --list-variables
  foldwing check wing.toml --draw wing.svg
  foldwing check wing.toml --unknowns
  foldwing check wing.toml --json";

pub(super) const STATIC: &str = "\
Examples:
  foldwing static wing.toml
  foldwing static wing.toml --set fold.release=0
  foldwing static wing.toml --set load.outer[4].force.z=0.2 --set gravity.x=0 --json";

pub(super) const TRIM: &str = "\
Examples:
  foldwing trim flared_wing_tip.toml --solve-for wind.velocity.z --target root.force.z=0
  foldwing trim flared_wing_tip.toml --solve-for wind.velocity.z --target root.moment.y=0";

pub(super) const FLUTTER: &str = "\
Examples:
  foldwing flutter goland_wing.toml --wind-m-s 50:200:16
  foldwing flutter goland_wing.toml --wind-m-s 50:200:7 --plot flutter --csv flutter.csv
  foldwing flutter goland_wing.toml --wind-m-s 50:200:31 --view flutter.html
  foldwing flutter goland_wing.toml --wind-m-s 100:200:5 --vary aero.density=0.8,1.0,1.225
  foldwing flutter flared_wing_tip.toml --wind-m-s 10:40:4 --vary fold.start_angle=0:1.4:3";

pub(super) const GRADIENT: &str = "\
Examples:
  foldwing gradient wing.toml --of fold.latch_time --by fold.motor_stiffness,fold.motor_damping
  foldwing gradient wing.toml --of gauge.root.strain@0.2 --by file:body.outer.length_m
  foldwing gradient wing.toml --of tip.position@0.2 --by fold.motor_constant_torque --json";

pub(super) const FIT: &str = "\
Examples:
  foldwing fit wing.toml measured.csv --by fold.motor_damping,file:body.outer.length_m
  foldwing fit wing.toml measured.csv --by fold.motor_damping --bounds fold.motor_damping=0:0.01
  foldwing fit wing.toml measured.csv --by fold.motor_damping --sigma fold.angle=2e-3 --plot figures";

pub(super) const MODES: &str = "\
Examples:
  foldwing modes wing.toml
  foldwing modes wing.toml --state undeformed --count 4 --set fold.start_angle=0
  foldwing modes wing.toml --set fold.release=0 --set root.angular_velocity.z=20 --json
  foldwing modes wing.toml --view modes.html --vtk modes
  foldwing modes wing.toml --set fold.release=0 --vary root.angular_velocity.z=0:40:5 --plot modes
  foldwing modes turbine.toml --state undeformed --vary rotor_speed_rpm=0:18:19 --plot campbell";

pub(super) const PERIODIC: &str = "\
Examples:
  foldwing periodic turbine.toml --speed-rpm 12.1
  foldwing periodic turbine.toml --speed-rpm 12.1 --variables \"body.*\" --count 0 --csv turn.csv
  foldwing periodic turbine.toml --speed-rpm 12.1 --count 6 --view floquet.html
  foldwing periodic turbine.toml --speed-rpm 9 --shaft shaft --json";

pub(super) const OPERATING_POINTS: &str = "\
Examples:
  foldwing operating-points wt.toml --wind-m-s 5:11:7 --speed-rpm 40
  foldwing operating-points wt.toml --wind-m-s 8 --speed-rpm 20:60:5 --pitch-deg 0,4 --csv p.csv
  foldwing operating-points wt.toml --wind-m-s 4:12:9 --tip-speed-ratio 6 --speed-rpm 60
  foldwing operating-points wt.toml --wind-m-s 9 --solve-for pitch_deg=0:9 --target rotor.power=2e4
  foldwing operating-points wt.toml --wind-m-s 8 --solve-for speed_rpm=9:99 --target rotor.power=1e3

--tip-speed-ratio, --speed-rpm, --solve-for and --target together give the schedule of a
controller: below rated power, the rotor speed for the tip speed ratio, up to --speed-rpm; above
rated power, the pitch for rated power.";

pub(super) const LINEARIZE: &str = "\
Examples:
  foldwing linearize wing.toml -o wing.npz
  foldwing linearize wing.toml --state 0.3 --inputs load. --outputs tip.,gauge. -o wing.mat
  foldwing linearize wing.toml --state start --set fold.release=0 -o wing.json

The file contains A, B, C, D with the names, units and values at the operating point. States are
the free coordinates and their rates. `examples/damp_latched_wing.py` designs a feedback controller
with this model and tests it with the FMU.";

pub(super) const SCHEMA: &str = "\
Example, and the line at the top of a model file by which editors find the schema:
  foldwing schema > foldwing.schema.json
  #:schema ./foldwing.schema.json";
