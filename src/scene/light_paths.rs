//! The wish for paths from the lights.

/// When paths are traced from the lights beside those from the camera.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum LightPaths {
    /// Where the plan finds that they pay, and but for light that light samples find as well.
    #[default]
    Auto,
    /// Wherever they can be, for all light.
    On,
    /// Never.
    Off,
}

impl LightPaths {
    /// As scene files and the command line have it.
    pub fn name(self) -> &'static str {
        match self {
            LightPaths::Auto => "auto",
            LightPaths::On => "on",
            LightPaths::Off => "off",
        }
    }
}
