//! A number for what a scene says: equal for equal content, wherever its files are.

use super::{Environment, EnvironmentImage, Integrator, LightPaths, Mesh, PathReuse, Roulette, Scene, Texels};
use crate::film::checksum::Checksum;
use std::fmt::Write as _;
use std::sync::Arc;

impl Scene {
    /// XXH64 of everything that decides the image: camera, film size, integrator, environment texels, triangles,
    /// spheres, materials. Neither the paths nor what was assumed count.
    ///
    /// Small values go in as their `Debug` text, which tells every f32 from every other.
    pub fn fingerprint(&self) -> u64 {
        let mut sum = Checksum::default();
        // Whoever adds a field says here what becomes of it.
        let Scene {
            name: _,
            assumptions: _,
            files: _,
            camera,
            film,
            integrator,
            environment,
            delta_lights,
            mesh,
            spheres,
            materials,
        } = self;
        // How the image is found changes its noise and not what it shows; states say it themselves.
        let (light_paths, path_reuse, roulette) = (LightPaths::Auto, PathReuse::Auto, Roulette::default());
        let integrator = Integrator { light_paths, path_reuse, roulette, ..*integrator };
        // Writing into a checksum cannot fail.
        let _ = write!(sum, "{camera:?}{film:?}{integrator:?}{spheres:?}{materials:?}{delta_lights:?}");
        match environment {
            Some(Environment::Image(EnvironmentImage { width, height, texels, rotation })) => {
                let _ = write!(sum, "{width}x{height} {rotation:?}");
                floats(&mut sum, texels);
            }
            small => {
                let _ = write!(sum, "{small:?}");
            }
        }
        let Mesh { positions, triangles, material, normals, normal_indices, texcoords, texcoord_indices } = mesh;
        let _ = write!(sum, "{} {} {}", positions.len(), triangles.len(), normals.len());
        floats(&mut sum, positions);
        floats(&mut sum, normals);
        words(&mut sum, triangles.iter().chain(normal_indices).flatten().copied());
        words(&mut sum, material.iter().copied());
        words(&mut sum, texcoords.iter().flatten().map(|x| x.to_bits()));
        words(&mut sum, texcoord_indices.iter().flatten().copied());
        self.texels(&mut sum);
        sum.value()
    }
}

impl Scene {
    /// Texels of the images, whose `Debug` text leaves them out; each image once.
    fn texels(&self, sum: &mut Checksum) {
        let mut seen = Vec::new();
        for texture in self.materials.iter().flat_map(|material| material.maps.textures()) {
            let image = Arc::as_ptr(&texture.image);
            let number = seen.iter().position(|&known| known == image).unwrap_or(seen.len());
            words(sum, [number as u32].into_iter());
            if number < seen.len() {
                continue;
            }
            seen.push(image);
            match &texture.image.texels {
                Texels::Bytes(values) => sum.update(values),
                Texels::Words(values) => words(sum, values.iter().map(|&word| u32::from(word))),
                Texels::Floats(values) => words(sum, values.iter().map(|x| x.to_bits())),
            }
        }
    }
}

fn floats(sum: &mut Checksum, values: &[[f32; 3]]) {
    words(sum, values.iter().flatten().map(|x| x.to_bits()));
}

fn words(sum: &mut Checksum, values: impl Iterator<Item = u32>) {
    let mut buffer = [0; 4096];
    let mut used = 0;
    for value in values {
        buffer[used..used + 4].copy_from_slice(&value.to_le_bytes());
        used += 4;
        if used == buffer.len() {
            sum.update(&buffer);
            used = 0;
        }
    }
    sum.update(&buffer[..used]);
}
