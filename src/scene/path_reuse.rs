//! The wish for pixels that share paths.

/// When pixels of a group share what their paths find after the first bounce. Unbiased, and mostly far less noise in the
/// same time; the errors of the pixels of a group are then no longer independent of each other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum PathReuse {
    /// Where the plan finds that it can be.
    #[default]
    Auto,
    /// Never: every pixel by paths of its own.
    Off,
}

impl PathReuse {
    /// As scene files and the command line have it.
    pub fn name(self) -> &'static str {
        match self {
            PathReuse::Auto => "auto",
            PathReuse::Off => "off",
        }
    }
}
