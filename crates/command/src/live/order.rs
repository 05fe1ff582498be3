//! Commands of a page.

use serde::Deserialize;

/// Maximum number of variables in all plots together.
pub(super) const MOST_WATCHED: usize = 64;

/// Limits of the speed: simulated seconds per second.
pub const SPEEDS: [f64; 2] = [1e-3, 100.0];

/// Limits of the spring stiffness in N/m.
const STIFFNESSES_N_M: [f64; 2] = [1e-9, 1e12];

/// Limit of coordinates in m, far beyond the size of any model.
const FARTHEST_M: f64 = 1e6;

/// Value of an input or parameter.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(untagged)]
pub enum Given {
    /// Value of a Boolean.
    Switch(bool),
    /// Value of a real or an integer.
    Number(f64),
}

/// Command of a page.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(tag = "do", rename_all = "snake_case", deny_unknown_fields)]
pub enum Order {
    /// Start the clock.
    Run {},
    /// Stop the clock.
    Pause {},
    /// Perform one communication step and stop.
    Step {},
    /// Return to the start of the simulation.
    Restart {},
    /// Return to the last frame at or before a time, and stop there.
    Rollback {
        /// Time in s.
        time_s: f64,
    },
    /// Set the speed in simulated seconds per second.
    Speed {
        /// Speed; 1 is real time.
        value: f64,
    },
    /// Set an input or a tunable parameter.
    Set {
        /// Its name.
        name: String,
        /// Its value in the variable's unit.
        value: Given,
        /// Index of the machine [default: all machines with an input or parameter of this name].
        #[serde(default)]
        machine: Option<usize>,
    },
    /// Send the values of further outputs over time.
    Watch {
        /// Their names.
        names: Vec<String>,
    },
    /// Attach a spring to a load station of a machine.
    Pull {
        /// Index of the station, over all bodies.
        station: usize,
        /// Free end of the spring in m in the root frame.
        target_m: [f64; 3],
        /// Stiffness in N/m.
        stiffness_n_m: f64,
        /// Index of the machine.
        #[serde(default)]
        machine: usize,
    },
    /// Remove the springs.
    Release {},
}

impl Order {
    /// Parses the text of a message.
    ///
    /// # Errors
    /// Text that is not a command, and numbers out of range, with the allowed values.
    pub fn read(text: &str) -> Result<Self, String> {
        let order: Self = serde_json::from_str(text).map_err(|error| format!("a message is not a command: {error}"))?;
        let within = |what: &str, value: f64, [least, most]: [f64; 2], unit: &str| match (least..=most).contains(&value)
        {
            true => Ok(()),
            false => Err(format!("{what} cannot be {value}: it must be from {least} to {most}{unit}")),
        };
        match &order {
            Self::Rollback { time_s } => within("the rollback time", *time_s, [-1e9, 1e9], " s"),
            Self::Speed { value } => within("the speed", *value, SPEEDS, ""),
            Self::Pull { target_m, stiffness_n_m, .. } => {
                within("the stiffness of the spring", *stiffness_n_m, STIFFNESSES_N_M, " N/m")?;
                let far = [-FARTHEST_M, FARTHEST_M];
                target_m.iter().try_for_each(|place_m| within("the end of the spring", *place_m, far, " m"))
            }
            Self::Watch { names } if names.len() > MOST_WATCHED => {
                Err(format!("{} outputs cannot be plotted at once: at most {MOST_WATCHED} can", names.len()))
            }
            Self::Run {}
            | Self::Pause {}
            | Self::Step {}
            | Self::Restart {}
            | Self::Set { .. }
            | Self::Watch { .. }
            | Self::Release {} => Ok(()),
        }?;
        Ok(order)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_are_read_or_refused_with_what_is_allowed() {
        assert_eq!(Order::read(r#"{"do":"run"}"#), Ok(Order::Run {}));
        let set = Order::Set { name: "a".to_owned(), value: Given::Switch(true), machine: None };
        assert_eq!(Order::read(r#"{"do":"set","name":"a","value":true}"#), Ok(set));
        for (text, needed) in [
            ("", "a message is not a command"),
            ("[1]", "a message is not a command"),
            (r#"{"do":"fly"}"#, "unknown variant `fly`"),
            (r#"{"do":"run","now":1}"#, "unknown field `now`"),
            (r#"{"do":"set","name":"a"}"#, "missing field `value`"),
            (r#"{"do":"set","name":"a","value":"x"}"#, "a message is not a command"),
            (r#"{"do":"set","name":"a","value":1e999}"#, "number out of range"),
            (r#"{"do":"speed","value":0}"#, "the speed cannot be 0: it must be from 0.001 to 100"),
            (r#"{"do":"speed","value":-1}"#, "the speed cannot be -1"),
            (r#"{"do":"rollback","time_s":1e300}"#, "the rollback time cannot be"),
            (r#"{"do":"pull","station":0,"target_m":[0,0,2e6],"stiffness_n_m":1}"#, "the end of the spring cannot be"),
            (r#"{"do":"pull","station":0,"target_m":[0,0,0],"stiffness_n_m":-1}"#, "from 0.000000001 to"),
            (r#"{"do":"set","name":"a","value":1,"machine":-1}"#, "a message is not a command"),
            (r#"{"do":"pull","station":-1,"target_m":[0,0,0],"stiffness_n_m":1}"#, "a message is not a command"),
        ] {
            let message = Order::read(text).unwrap_err();
            assert!(message.contains(needed), "{text}: {message}");
        }
        let names = vec!["\"a\""; MOST_WATCHED + 1].join(",");
        let message = Order::read(&format!("{{\"do\":\"watch\",\"names\":[{names}]}}")).unwrap_err();
        assert_eq!(message, "65 outputs cannot be plotted at once: at most 64 can");
    }
}
