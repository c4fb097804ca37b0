//! Three f64.

use std::ops::{Add, Mul, Neg, Sub};

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct V3(pub [f64; 3]);

impl V3 {
    pub const Z: V3 = V3([0.0, 0.0, 1.0]);

    pub fn new(x: f64, y: f64, z: f64) -> Self {
        V3([x, y, z])
    }

    pub fn of(a: [f32; 3]) -> Self {
        V3(a.map(f64::from))
    }

    pub fn x(self) -> f64 {
        self.0[0]
    }

    pub fn y(self) -> f64 {
        self.0[1]
    }

    pub fn z(self) -> f64 {
        self.0[2]
    }

    pub fn dot(self, o: V3) -> f64 {
        self.0[0] * o.0[0] + self.0[1] * o.0[1] + self.0[2] * o.0[2]
    }

    pub fn cross(self, o: V3) -> V3 {
        let ([a, b, c], [d, e, f]) = (self.0, o.0);
        V3([b * f - c * e, c * d - a * f, a * e - b * d])
    }

    pub fn length(self) -> f64 {
        self.dot(self).sqrt()
    }

    pub fn unit(self) -> V3 {
        self * (1.0 / self.length())
    }

    /// Component by component.
    pub fn times(self, o: V3) -> V3 {
        V3(std::array::from_fn(|i| self.0[i] * o.0[i]))
    }

    pub fn max_component(self) -> f64 {
        self.0[0].max(self.0[1]).max(self.0[2])
    }
}

impl Add for V3 {
    type Output = V3;
    fn add(self, o: V3) -> V3 {
        V3(std::array::from_fn(|i| self.0[i] + o.0[i]))
    }
}

impl Sub for V3 {
    type Output = V3;
    fn sub(self, o: V3) -> V3 {
        self + -o
    }
}

impl Neg for V3 {
    type Output = V3;
    fn neg(self) -> V3 {
        V3(self.0.map(|a| -a))
    }
}

impl Mul<f64> for V3 {
    type Output = V3;
    fn mul(self, s: f64) -> V3 {
        V3(self.0.map(|a| a * s))
    }
}

/// An orthonormal frame about a unit vector, by Gram–Schmidt from the axis least aligned with it.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    x: V3,
    y: V3,
    z: V3,
}

impl Frame {
    pub fn about(z: V3) -> Self {
        let least = (0..3).fold(0, |b, i| if z.0[i].abs() < z.0[b].abs() { i } else { b });
        let axis = V3(std::array::from_fn(|i| f64::from(u8::from(i == least))));
        let x = (axis - z * axis.dot(z)).unit();
        Frame { x, y: z.cross(x), z }
    }

    pub fn to_local(self, w: V3) -> V3 {
        V3([w.dot(self.x), w.dot(self.y), w.dot(self.z)])
    }

    pub fn to_world(self, w: V3) -> V3 {
        self.x * w.x() + self.y * w.y() + self.z * w.z()
    }
}
