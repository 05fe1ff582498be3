//! The documents, the pages and descriptions written from the program, and the rules of the house, the list of planted faults.

mod architecture;
mod faults;
mod guide;
mod model_description;
