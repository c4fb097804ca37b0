//! What each random number is for.
//!
//! A sample draws [`CAMERA`] numbers, then [`BOUNCE`] for every bounce, always, whatever the scene contains: so the
//! numbers of one purpose do not shift when another is not needed.

/// Numbers drawn for the camera.
pub const CAMERA: usize = 4;
/// Where in the pixel, two numbers.
pub const PIXEL: usize = 0;
/// Where on the lens, two numbers.
pub const LENS: usize = 2;

/// Numbers drawn for each bounce.
pub const BOUNCE: usize = 12;
/// Which lobe of the BSDF.
pub const BSDF_LOBE: usize = 0;
/// Which direction of the lobe, two numbers.
pub const BSDF_DIRECTION: usize = 1;
/// Which of the lights without extent; and the digits below the last of [`LIGHT_POSITION`], whose first number chooses among
/// the others.
pub const LIGHT_CHOICE: usize = 3;
/// Which light, and where on it: two numbers.
pub const LIGHT_POSITION: usize = 4;
/// Russian roulette.
pub const ROULETTE: usize = 6;
/// Does a cut-out let the path pass?
pub const OPACITY: usize = 7;
/// By what angle a point set is turned.
pub const ROTATION: usize = 8;
/// The first of the reserved numbers.
pub const RESERVED: usize = 9;

const _: () = assert!(LENS + 2 == CAMERA && RESERVED < BOUNCE);
