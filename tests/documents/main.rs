//! The documents, the pages and descriptions generated from the program, the rules of the code, and the list of faults.

mod architecture;
mod faults;
mod guide;
mod model_description;
