//! Invalid, random or extreme input from users, importers and files: calls, arguments, models and machines.

mod calls;
#[path = "../verification/counting_allocator.rs"]
mod counting_allocator;
mod endurance;
mod faces;
mod failures;
mod fmi3;
mod fmi3_derivatives;
mod fmi_allocation;
mod fmi_calls;
mod fmi_capabilities;
mod fmi_semantics;
mod fmu;
mod fmu3;
mod life_cycle;
mod loggers;
mod machine_in_code;
mod machine_random;
mod machine_refusals;
#[path = "../machines/mod.rs"]
mod machines;
mod model_exchange;
mod model_exchange_derivatives;
mod model_exchange_states;
mod model_file;
mod model_file_accepted;
mod model_file_air;
mod model_file_failures;
mod model_file_flaps;
mod model_file_functions;
mod model_file_joints;
mod model_file_keys;
mod model_file_loops;
mod model_file_meaning;
mod model_file_meant;
mod model_file_shapes;
mod model_file_units;
mod mutated_inputs;
mod random_arguments;
mod random_calls;
mod random_faces;
mod random_session;
mod rolled_back;
mod saved_numbers;
#[path = "../verification/share.rs"]
mod share;
mod standard;
mod watchdog;
