//! A reference image and what its maker measured of its noise.

use octolux::film::read_exr;
use std::path::Path;

pub struct Reference {
    pub width: u32,
    pub height: u32,
    /// Row by row.
    pub pixels: Vec<[f64; 3]>,
    pub mean: [f64; 3],
    /// Standard error of each channel's image mean.
    pub mean_error: [f64; 3],
    /// Root mean square noise of a pixel, over pixels and channels.
    pub rmse_floor: f64,
    /// What its noise adds to any relMSE measured against it.
    pub relmse_floor: f64,
}

impl Reference {
    pub fn load(folder: &Path, name: &str) -> Self {
        let image = read_exr(&folder.join(format!("{name}.exr"))).expect("the reference image loads");
        let text = std::fs::read_to_string(folder.join(format!("{name}.json"))).expect("the reference has facts");
        let facts: serde_json::Value = serde_json::from_str(&text).expect("they are JSON");
        let number = |value: &serde_json::Value| value.as_f64().unwrap_or_else(|| panic!("{name}.json: {value}"));
        let planes = image.rgb();
        let pixels: Vec<[f64; 3]> =
            (0..planes[0].len()).map(|i| std::array::from_fn(|c| f64::from(planes[c][i]))).collect();
        let mean = std::array::from_fn(|c| pixels.iter().map(|p| p[c]).sum::<f64>() / pixels.len() as f64);
        Reference {
            width: image.width,
            height: image.height,
            pixels,
            mean,
            mean_error: std::array::from_fn(|c| number(&facts["mean_sem"][c])),
            rmse_floor: number(&facts["rmse_floor"]),
            relmse_floor: number(&facts["relmse_floor"]),
        }
    }
}
