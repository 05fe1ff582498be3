//! The documents, the pages and descriptions written from the program, and the rules of the house.

mod architecture;
mod guide;
mod model_description;
