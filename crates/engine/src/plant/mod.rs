//! A machine to be run and studied: the public interface of [`crate::system`], [`crate::study`], [`crate::run`] and
//! [`crate::gradient`].

pub use crate::gradient::{Gradient, GradientError, InputColumn, InputRows, Parameter, RunPieces, RunResult, Tape};
pub use crate::run::{
    Floquet, FloquetMode, Harmonic, Latency, NearbyMotion, Pauses, PeriodicMotion, Plant, Reached, SAMPLES, Seen,
    Settled, Turn,
};
pub use crate::signal::{
    BodyParameters, Count, DcMotorInputs, FACTOR_RANGE, FlapInputs, InputLayout, Inputs, JointInputs, JointParameters,
    ParameterLayout, Parameters, SolverParameters, SpatialParameters, Switch,
};
pub use crate::study::{
    Accuracy, Argument, AveragedModes, Beside, Branch, Branches, Coarseness, Crossing, Departure, Dropped, FlightLoad,
    Followed, Growth, Holding, InputSlope, InstantRates, JUDGED_MODES, Keep, LoadPath, NoReduction, PathPoint, Place,
    Reduced, Rest, Rotor, SampledSpace, Search, SecondOrder, Stability, StateSpace, StaticEffort, Study, Whirl,
    change_of_sign, reduce, reduce_in_band, reduce_sampled, sampled,
};
pub use crate::system::{
    AccountRates, CLOSED_PANELS, CoordinateName, CoordinateQuantity, DcMotorOutputs, EnergyOutputs, FailureOutputs,
    FastestMotion, FlapOutputs, FlightMode, Freedom, GeneratorOutputs, Hybrid, JointOutputs, JointStatus, Jump,
    LatchOutputs, LoopOutputs, ModalOutputs, ModeShape, NoSlipOutputs, NodeMotion, NotHybrid, OutputLayout, OutputSet,
    Outputs, PlantError, PointOutputs, RotorLoads, SHEAR_SHARE, SectionChange, SectionPlace, SectionShape,
    SectionState, SectionStrain, Snapshot, SpatialOutputs, Statistics, SurfaceGap, SurfaceLattice, System, WhirlShare,
    energy_share_names,
};
