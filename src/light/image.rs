//! A latitude-longitude image: looking it up, and sampling directions in proportion to what the look-up returns.

use super::density::{Density, Shape};
use super::environment::SkySamples;
use crate::lane::array::map;
use crate::lane::math::{atan2, sincos_2pi};
use crate::lane::{Bits, MAX_WIDTH, Mask, Real, Vec3, prefetch};
use crate::scene::EnvironmentImage;
use core::f32::consts::FRAC_1_PI;
use rayon::prelude::*;

/// Keeps the distance from a pole positive, so that at the pole itself density / sin θ takes its limit instead of
/// 0/0. Far below anything a direction can resolve, and its quotients stay in range.
const POLE: f32 = 1e-18;

/// The least share of a sky's light above its mean that is worth samples of its own: below, rounding could decide.
const LEAST_EXCESS: f64 = 0.01;

/// The image with its sampling density.
pub struct ImageMap {
    shape: Shape,
    /// Row-major r, g, b, and pdf_ω · sin θ / weight of the cell above and to the right, which needs one row
    /// more than the image has.
    texels: Vec<[f32; 4]>,
    /// What sampling is proportional to at a texel's centre is the sum of its channels, less three times the floor, times
    /// this of its row: the mean relative to the largest, times the row's sin θ.
    row_weight: Vec<f32>,
    /// A mean over the channels that counts as nothing: the sky's where samples are compensated, else 0.
    floor: f32,
    density: Density,
}

/// Where a direction falls between four texel centres.
///
/// Rows are counted from the nearer pole, so that positions near either are resolved relatively. Row cell 0 lies
/// between the pole and the first row of centres and is half as high as the others.
pub(super) struct Place<R: Real> {
    /// The column of centres to the left.
    column: R::Bits,
    /// The row of centres away from the pole; the one towards it is `row` − 1.
    row: R::Bits,
    /// Is the nearer pole the one at −y?
    south: R::Mask,
    /// Position between the columns, from left to right, and between the rows, away from the pole, in [0, 1].
    x: R,
    y: R,
}

/// The four centres around a place: index 0 towards the pole.
struct Corners<R> {
    radiance: [[Vec3<R>; 2]; 2],
    weight: [[R; 2]; 2],
    /// pdf_ω · sin θ / interpolated weight.
    scale: R,
}

impl ImageMap {
    /// `None` where the image is black.
    pub(super) fn build(image: &EnvironmentImage, samples: SkySamples) -> Option<Self> {
        let shape = Shape { width: image.width, height: image.height };
        // (An image without columns has no texels.)
        let rows = image.texels.par_chunks_exact(image.width.max(1));
        let largest = rows.map(|row| over_means(row, |mean| mean, f64::max)).reduce(|| 0.0, f64::max);
        if largest <= 0.0 {
            return None;
        }
        let sin_theta = |row: usize| (std::f64::consts::PI * (row as f64 + 0.5) / image.height as f64).sin();
        // A tiny `largest` would leave the range of f32; only ratios matter.
        let row_weight: Vec<f32> =
            (0..image.height).map(|row| (sin_theta(row) / (3.0 * largest)).min(f64::from(f32::MAX)) as f32).collect();
        let floor = if samples == SkySamples::Compensated { floor(image, sin_theta) } else { 0.0 };
        let weight = |row: usize, column: usize| {
            let [r, g, b] = image.texels[row * image.width + column];
            weight(Vec3::new(r, g, b), row_weight[row], floor)
        };
        let (density, scale) = Density::build(shape, weight);
        let last_row = &image.texels[image.texels.len() - image.width..];
        let texels = image.texels.par_iter().chain(last_row).zip(&scale).map(|([r, g, b], s)| [*r, *g, *b, *s]);
        Some(Self { shape, texels: texels.collect(), row_weight, floor, density })
    }

    pub(super) fn memory(&self) -> usize {
        size_of_val(&*self.texels) + size_of_val(&*self.row_weight) + self.density.memory()
    }

    #[inline(always)]
    pub(super) fn radiance<R: Real>(&self, d: Vec3<R>) -> Vec3<R> {
        let (place, _) = self.locate(d);
        self.corners(&place).radiance_at(&place)
    }

    #[inline(always)]
    pub(super) fn radiance_and_pdf<R: Real>(&self, d: Vec3<R>) -> (Vec3<R>, R) {
        let (place, sin_theta) = self.locate(d);
        let corners = self.corners(&place);
        (corners.radiance_at(&place), self.pdf(&place, &corners, sin_theta))
    }

    /// Direction, radiance, pdf.
    #[inline(always)]
    pub(super) fn sample<R: Real>(&self, u: [R; 2]) -> (Vec3<R>, Vec3<R>, R) {
        let cell = self.density.choose(u);
        let mut place = Place { column: cell.column, row: cell.row, south: cell.south, x: cell.x, y: cell.y };
        let corners = self.corners(&place);
        let [near, far] = map(corners.weight, |[left, right]| left + right);
        place.y = invert_linear(place.y, near, far);
        let mix = |side: usize| lerp(corners.weight[0][side], corners.weight[1][side], place.y);
        place.x = invert_linear(place.x, mix(0), mix(1));
        let polar = place.is_polar();
        place.y = place.y.max_or(R::splat(POLE));

        let (d, sin_theta) = self.direction(&place, polar);
        (d, corners.radiance_at(&place), self.pdf(&place, &corners, sin_theta))
    }

    /// The place that `d` looks at, and the sine of its angle to the pole.
    #[inline(always)]
    fn locate<R: Real>(&self, d: Vec3<R>) -> (Place<R>, R) {
        let (width, height) = (R::splat(self.shape.width as f32), R::splat(self.shape.height as f32));
        // Not wrapped to [0, 1) before scaling: just left of the seam that would cost half the digits.
        let u = atan2(d.x, -d.z) * R::splat(0.5 * FRAC_1_PI);
        let from_left = u.mul_add(width, R::splat(-0.5));
        let left = from_left.floor();
        let x = from_left - left;
        let wrapped = R::select(left.lt(R::zero()), left + width, left);
        let column = clamp_index(wrapped, self.shape.width - 1);

        let sin_theta = d.x.mul_add(d.x, d.z * d.z).sqrt().max_or(R::splat(POLE));
        let rows = atan2(sin_theta, d.y.abs()) * R::splat(FRAC_1_PI) * height;
        let from_pole = rows + R::splat(0.5);
        let whole = from_pole.floor();
        let row = clamp_index(whole, self.shape.height.div_ceil(2));
        let polar = row.eq(R::Bits::splat(0));
        let y = R::select(polar, rows + rows, from_pole - whole);
        (Place { column, row, south: d.y.lt(R::zero()), x, y }, sin_theta)
    }

    /// The direction towards a place, and the sine of its angle to the pole.
    #[inline(always)]
    fn direction<R: Real>(&self, place: &Place<R>, polar: R::Mask) -> (Vec3<R>, R) {
        let half = R::splat(0.5);
        let rows = R::select(polar, half * place.y, R::from_int(place.row) - half + place.y);
        let (sin_theta, cos_theta) = sincos_2pi(rows * R::splat(0.5 / self.shape.height as f32));
        // Signed columns keep the digits that wrapping would cost left of the seam.
        let column = R::from_int(place.column);
        let width = R::splat(self.shape.width as f32);
        let signed = R::select((column + column + R::one()).ge(width), column - width, column);
        let turns = (signed + half + place.x) * R::splat(1.0 / self.shape.width as f32);
        let (sin_abs, cos_phi) = sincos_2pi(turns.abs());
        let sin_phi = R::select(turns.lt(R::zero()), -sin_abs, sin_abs);
        let y = R::select(place.south, -cos_theta, cos_theta);
        (Vec3::new(sin_theta * sin_phi, y, -(sin_theta * cos_phi)), sin_theta)
    }

    /// pdf_ω = pdf_uv / (2π² sinθ).
    #[inline(always)]
    fn pdf<R: Real>(&self, place: &Place<R>, corners: &Corners<R>, sin_theta: R) -> R {
        let pdf = corners.scale * corners.weight_at(place) / sin_theta;
        pdf.masked(pdf.is_finite())
    }

    #[inline(always)]
    fn corners<R: Real>(&self, place: &Place<R>) -> Corners<R> {
        // All addresses first: the fetches of sixteen lanes then wait for the cache together.
        let mut at = [[0; MAX_WIDTH]; 5];
        let mut row_weight = [[0.0; MAX_WIDTH]; 2];
        for lane in 0..R::WIDTH {
            let left = place.column.lane(lane) as usize;
            let right = if left + 1 == self.shape.width { 0 } else { left + 1 };
            let (row, south) = (place.row.lane(lane) as usize, place.south.lane(lane));
            for (i, row) in self.shape.corner_rows(row, south).into_iter().enumerate() {
                at[2 * i][lane] = (row * self.shape.width + left) as u32;
                at[2 * i + 1][lane] = (row * self.shape.width + right) as u32;
                row_weight[i][lane] = self.row_weight[row];
                prefetch(self.texels.as_ptr().wrapping_add(row * self.shape.width + left));
            }
            at[4][lane] = (self.shape.row_cell(row, south) * self.shape.width + left) as u32;
        }
        let radiance = map([[0, 1], [2, 3]], |corners| {
            map(corners, |k| {
                let [r, g, b, _] = R::fetch_rows(&self.texels, R::Bits::load(&at[k]));
                Vec3::new(r, g, b)
            })
        });
        // Nothing is lost towards a pole, where sin θ takes the weight to 0 whatever the radiance.
        let near = R::load(&row_weight[0]).masked(!place.is_polar());
        let far = R::load(&row_weight[1]);
        let weight =
            [map(radiance[0], |c| weight(c, near, self.floor)), map(radiance[1], |c| weight(c, far, self.floor))];
        Corners { radiance, weight, scale: R::from_fn(|lane| self.texels[at[4][lane] as usize][3]) }
    }
}

/// The mean radiance over the sphere, the texels weighed by their rows' sin θ: 0 where too little lies above it.
fn floor(image: &EnvironmentImage, sin_theta: impl Fn(usize) -> f64 + Sync) -> f32 {
    let total = over_rows(image, &sin_theta, |mean| mean);
    let area = image.width as f64 * (0..image.height).map(&sin_theta).sum::<f64>();
    let floor = (total / area) as f32;
    let excess = over_rows(image, &sin_theta, |mean| (mean - f64::from(floor)).max(0.0));
    if excess > LEAST_EXCESS * total { floor } else { 0.0 }
}

/// The sum of `of` each texel's mean, times its row's sin θ: in the order of the rows, whatever the threads.
fn over_rows(
    image: &EnvironmentImage,
    sin_theta: &(impl Fn(usize) -> f64 + Sync),
    of: impl Fn(f64) -> f64 + Sync,
) -> f64 {
    let rows = image.texels.par_chunks_exact(image.width).enumerate();
    let sums = rows.map(|(j, row)| sin_theta(j) * over_means(row, &of, |a, b| a + b));
    sums.collect::<Vec<_>>().into_iter().sum()
}

/// `join`s `of` each texel's mean to 0: eight beside each other, then what these came to.
fn over_means(row: &[[f32; 3]], of: impl Fn(f64) -> f64, join: impl Fn(f64, f64) -> f64) -> f64 {
    let (eights, rest) = row.as_chunks::<8>();
    let mut partial = [0.0; 8];
    for texels in eights.iter().map(|eight| &eight[..]).chain([rest]) {
        for (partial, [r, g, b]) in partial.iter_mut().zip(texels) {
            *partial = join(*partial, of((f64::from(*r) + f64::from(*g) + f64::from(*b)) / 3.0));
        }
    }
    partial.into_iter().fold(0.0, join)
}

/// The sum of the channels less three times `floor`, times `row`, in a form that does not overflow where the products do not.
#[inline(always)]
fn weight<R: Real>(c: Vec3<R>, row: R, floor: f32) -> R {
    let less = R::splat(floor) * row * R::splat(3.0);
    c.x.mul_add(row, c.y.mul_add(row, c.z.mul_add(row, -less))).max_or(R::zero())
}

impl<R: Real> Place<R> {
    #[inline(always)]
    fn is_polar(&self) -> R::Mask {
        self.row.eq(R::Bits::splat(0))
    }
}

impl<R: Real> Corners<R> {
    #[inline(always)]
    fn radiance_at(&self, place: &Place<R>) -> Vec3<R> {
        let [near, far] = map(self.radiance, |[left, right]| {
            Vec3::new(lerp(left.x, right.x, place.x), lerp(left.y, right.y, place.x), lerp(left.z, right.z, place.x))
        });
        Vec3::new(lerp(near.x, far.x, place.y), lerp(near.y, far.y, place.y), lerp(near.z, far.z, place.y))
    }

    #[inline(always)]
    fn weight_at(&self, place: &Place<R>) -> R {
        let [near, far] = map(self.weight, |[left, right]| lerp(left, right, place.x));
        lerp(near, far, place.y)
    }
}

/// `(1 − t)·a + t·b`: exact at both ends and for a = b = 2ⁿ, and free of cancellation for a, b ≥ 0.
#[inline(always)]
fn lerp<R: Real>(a: R, b: R, t: R) -> R {
    b.mul_add(t, a * (R::one() - t))
}

/// The x in [0, 1] below which a density ∝ (1 − x)·a + x·b (a, b ≥ 0) holds the share `u`; uniform where both are 0.
/// The quadratic's root in the form that does not cancel (Pharr, Jakob, Humphreys 2023, §A.4.1).
#[inline(always)]
fn invert_linear<R: Real>(u: R, a: R, b: R) -> R {
    let sum = a + b;
    let a = a / sum;
    let b = b / sum;
    let root = lerp(a * a, b * b, u).safe_sqrt();
    let x = u / (a + root);
    // 0/0 where u = a = 0: the limit is 0, which a NaN gives way to.
    R::select(sum.gt(R::zero()), x.max_or(R::zero()).min_or(R::one()), u)
}

/// `value` in 0 …= `last`; NaN counts as 0, so that dead lanes read somewhere valid.
#[inline(always)]
fn clamp_index<R: Real>(value: R, last: usize) -> R::Bits {
    value.max_or(R::zero()).min_or(R::splat(last as f32)).to_int()
}
