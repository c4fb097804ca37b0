pub mod lane;
pub mod scene;
