//! `[sim]`: how the world behaves where it is not the robots' own doing.

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// How the world behaves.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SimTable {
    /// The floor crew takes a machine off the floor whose agent has been silent for this long, seconds, or
    /// `"never"`.
    pub carry_off_after_s: CarryOff,
    /// Noise of the localisation's fixes: standard deviation along each axis, metres. It is cut off at 2.3 of
    /// it, so that its bound is an honest one.
    pub fix_sigma_m: f64,
    /// Noise of the fixes' heading: standard deviation, radians.
    pub fix_heading_sigma_rad: f64,
    /// How far the wheels' odometry is off at most, as a share of the way.
    pub odometry_error: f64,
}

impl Default for SimTable {
    fn default() -> Self {
        Self {
            carry_off_after_s: CarryOff::After(60.0),
            fix_sigma_m: 0.003,
            fix_heading_sigma_rad: 0.003,
            odometry_error: 0.002,
        }
    }
}

/// When the floor crew takes a dead machine off the floor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CarryOff {
    /// After so many seconds of silence.
    After(f64),
    /// It stays where it is.
    Never,
}

impl CarryOff {
    /// Seconds of silence; infinite for never.
    pub fn seconds(self) -> f64 {
        match self {
            Self::After(seconds) => seconds,
            Self::Never => f64::INFINITY,
        }
    }
}

#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
#[schemars(inline)]
enum SecondsOrNever {
    Seconds(f64),
    Word(Never),
}

#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[schemars(inline)]
enum Never {
    Never,
}

impl Serialize for CarryOff {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match *self {
            Self::After(seconds) => SecondsOrNever::Seconds(seconds),
            Self::Never => SecondsOrNever::Word(Never::Never),
        }
        .serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for CarryOff {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let value = SecondsOrNever::deserialize(deserializer)
            .map_err(|_| serde::de::Error::custom("expected a number of seconds, or \"never\""))?;
        match value {
            SecondsOrNever::Seconds(seconds) => Ok(Self::After(seconds)),
            SecondsOrNever::Word(Never::Never) => Ok(Self::Never),
        }
    }
}

impl JsonSchema for CarryOff {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "CarryOff".into()
    }

    fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        SecondsOrNever::json_schema(generator)
    }
}
