// What happens at a vertex, a register of paths at a time.
#pragma once
#include "trace.h"

struct Look {
    V radiance;
    F pdf;
};

static inline I inside(I i, int size) {
    i = i < 0 ? I{} : i;
    return i >= size ? I{} + (size - 1) : i;
}

// The sky at a point of the image: bilinear radiance, and the density of its alias table per solid angle.
static inline Look sky_at(const Environment& sky, F u, F v, F sine) {
    F x = u * float(sky.w) - 0.5f, y = v * float(sky.h) - 0.5f, fx = floor_(x), fy = floor_(y), tx = x - fx, ty = y - fy;
    I i0 = to_int(fx), j0 = to_int(fy), i1 = i0 + 1, j1 = j0 + 1;
    i0 = i0 < 0 ? i0 + sky.w : i0, i1 = i1 >= sky.w ? i1 - sky.w : i1;
    // Lanes without a path may hold anything: their addresses are kept inside.
    i0 = inside(i0, sky.w), i1 = inside(i1, sky.w), j0 = inside(j0, sky.h), j1 = inside(j1, sky.h);
    I a = (j0 * sky.w + i0) * 4, b = (j0 * sky.w + i1) * 4, c = (j1 * sky.w + i0) * 4, d = (j1 * sky.w + i1) * 4;
    F wa = (1 - tx) * (1 - ty), wb = tx * (1 - ty), wc = (1 - tx) * ty, wd = tx * ty;
    const float* t = sky.texels.data();
    auto channel = [&](int k) {
        return gather(t + k, a) * wa + gather(t + k, b) * wb + gather(t + k, c) * wc + gather(t + k, d) * wd;
    };
    // The texel around the point is the nearest of the four.
    F density = gather(t + 3, tx < 0.5f ? (ty < 0.5f ? a : c) : (ty < 0.5f ? b : d));
    return {{channel(0), channel(1), channel(2)}, density / max(sine * (2 * PI * PI), splat(1e-20f))};
}

static inline Look sky_along(const Environment& sky, V d) {
    F sine = root(d.x * d.x + d.z * d.z);
    // acos by atan2 of (sine, y), half a turn at most.
    return sky_at(sky, turns_of(d.x, -d.z), min(turns_of(sine, d.y) * 2.0f, splat(1)), sine);
}

static inline F heuristic(F p, F q) {
    F r = q / p;
    return 1.0f / (1.0f + r * r);
}

struct Frame {
    V t, b, n;
    V world(V l) const { return t * l.x + b * l.y + n * l.z; }
    V local(V w) const { return {dot(w, t), dot(w, b), dot(w, n)}; }
};
static inline Frame frame(V n) { // Duff et al. 2017
    F sign = n.z >= 0 ? splat(1) : splat(-1), a = -1.0f / (sign + n.z), b = n.x * n.y * a;
    return {{1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}, n};
}

static inline F conductor(F eta, F k, F c) {
    F c2 = c * c, s2 = 1.0f - c2, e2 = eta * eta, k2 = k * k, t0 = e2 - k2 - s2, a2b2 = root(t0 * t0 + 4.0f * e2 * k2),
      a = root(0.5f * (a2b2 + t0)), t1 = a2b2 + c2, t2 = 2.0f * c * a, rs = (t1 - t2) / (t1 + t2),
      t3 = c2 * a2b2 + s2 * s2, t4 = t2 * s2;
    return 0.5f * (rs + rs * (t3 - t4) / (t3 + t4));
}

struct Material {
    I metal;
    V albedo, eta, k;
    F alpha;
    V fresnel(F c) const { return {conductor(eta.x, k.x, c), conductor(eta.y, k.y, c), conductor(eta.z, k.z, c)}; }
    F g1(F cosine) const {
        F c2 = cosine * cosine, tan2 = max(1.0f - c2, splat(0)) / max(c2, splat(1e-12f));
        return 2.0f / (1.0f + root(1.0f + alpha * alpha * tan2));
    }
    F d(F cosine) const {
        F c2 = cosine * cosine, tan2 = max(1.0f - c2, splat(0)) / max(c2, splat(1e-12f)), a2 = alpha * alpha,
          e = 1.0f + tan2 / a2;
        return 1.0f / (PI * a2 * c2 * c2 * e * e);
    }
};

template <bool METALS> static inline Material material(const Scene& s, I m) {
    auto column = [&](int k) { return gather(s.table[k].data(), m); };
    Material out = {};
    out.albedo = {column(Scene::R), column(Scene::G), column(Scene::B)};
    if (METALS) {
        out.metal = gather(s.kind.data(), m) == 1;
        if (bits(out.metal)) {
            out.alpha = out.metal ? column(Scene::ALPHA) : splat(1);
            out.eta = {column(Scene::ETA), column(Scene::ETA + 1), column(Scene::ETA + 2)};
            out.k = {column(Scene::K), column(Scene::K + 1), column(Scene::K + 2)};
        }
    }
    return out;
}

// f cosθ and pdf; wo.z > 0.
template <bool METALS> static inline void evaluate(const Material& m, V wo, V wi, V& value, F& pdf) {
    value = m.albedo * (wi.z * (1 / PI));
    pdf = wi.z * (1 / PI);
    if (METALS && bits(m.metal)) {
        V h = unit(wo + wi);
        F c = dot(wo, h), gd = m.d(h.z) * m.g1(wo.z);
        F f = gd * m.g1(wi.z) / (4.0f * wo.z);
        value = select(m.metal, m.fresnel(c) * f, value);
        pdf = m.metal ? gd / (4.0f * wo.z) : pdf;
    }
}

template <bool METALS> static inline void sample(const Material& m, V wo, F u1, F u2, V& wi, V& weight, F& pdf) {
    F s, c, r = root(u1);
    turn(u2, s, c);
    V disc = {r * c, r * s, root(1.0f - u1)};
    wi = disc, weight = m.albedo, pdf = disc.z * (1 / PI);
    if (METALS && bits(m.metal)) { // visible normals, Heitz 2018
        V vh = unit({m.alpha * wo.x, m.alpha * wo.y, wo.z});
        F l2 = vh.x * vh.x + vh.y * vh.y, inverse = 1.0f / root(max(l2, splat(1e-20f)));
        I flat = l2 < 1e-14f;
        V t1 = {flat ? splat(1) : -vh.y * inverse, flat ? splat(0) : vh.x * inverse, splat(0)}, t2 = cross(vh, t1);
        F h = 0.5f * (1.0f + vh.z), p2 = (1.0f - h) * root(1.0f - disc.x * disc.x) + h * disc.y;
        V nh = t1 * disc.x + t2 * p2 + vh * root(1.0f - disc.x * disc.x - p2 * p2);
        V half = unit({m.alpha * nh.x, m.alpha * nh.y, max(nh.z, splat(1e-6f))});
        F along = dot(wo, half);
        V reflected = half * (2.0f * along) - wo;
        wi = select(m.metal, reflected, wi);
        weight = select(m.metal, m.fresnel(along) * m.g1(reflected.z), weight);
        pdf = m.metal ? m.d(half.z) * m.g1(wo.z) / (4.0f * wo.z) : pdf;
    }
}

// By a register: compressing stores are slow on Zen. Writes all lanes, of which the first count.
static inline void compress(float* to, unsigned mask, F x) { store_anywhere(to, compress(mask, x)); }

// One vertex of a register of paths: emission, light sample, next direction, roulette. Ended paths have bounce = -1 after it.
template <bool METALS> static void shade(const Scene& s, Wave& w, int at) {
    V d = {load(w.ray.dx + at), load(w.ray.dy + at), load(w.ray.dz + at)};
    V beta = {load(w.br + at), load(w.bg + at), load(w.bb + at)};
    V light = {load(w.lr + at), load(w.lg + at), load(w.lb + at)};
    F pdf = load(w.pdf + at), t = load(w.ray.far + at);
    I prim = *(I*)(w.prim + at), bounce = *(I*)(w.bounce + at);
    I lanes = numbers() + at, alive = lanes < w.alive, hit = alive & (prim >= 0);
    if (s.sky.w && bits(alive & ~hit)) {
        Look sky = sky_along(s.sky, d);
        F weight = heuristic(pdf, sky.pdf * s.environment_choice);
        light = select(alive & ~hit, light + beta * sky.radiance * weight, light);
    }
    prim = hit ? prim : I{};
    V ng = unit({load(w.nx + at), load(w.ny + at), load(w.nz + at)});
    F facing = -dot(ng, d);
    I m = gather(s.material.data(), prim);
    if (s.light_count) {
        I number = gather(s.light_of.data(), prim), emits = hit & (number >= 0) & (facing > 0);
        if (bits(emits)) {
            number = emits ? number : I{};
            auto column = [&](int k) { return gather(s.lights[k].data(), number); };
            F by_light = column(Scene::CHOICE) * t * t / (facing * column(Scene::AREA));
            V radiance = {column(Scene::L), column(Scene::L + 1), column(Scene::L + 2)};
            light = select(emits, light + beta * radiance * heuristic(pdf, by_light), light);
        }
    }
    I goes_on = hit & (bounce < s.max_bounces);
    V p = V{load(w.ray.ox + at), load(w.ray.oy + at), load(w.ray.oz + at)} + d * t;
    V n = select(facing < 0, ng * splat(-1), ng);
    Frame f = frame(n);
    V wo = f.local(d * splat(-1));
    wo.z = max(wo.z, splat(1e-6f));
    Material material = ::material<METALS>(s, m);
    Rng rng = {*(U*)(w.ra + at), *(U*)(w.rb + at)};
    // Light sample.
    F u0 = rng.next(), u1 = rng.next(), u2 = rng.next();
    V to = {}, radiance = {};
    F light_pdf = splat(0), far = splat(1e30f);
    I to_sky = s.sky.w ? (s.light_count ? u0 < s.environment_choice : I{} - 1) : I{};
    if (bits(to_sky)) {
        int count = s.sky.w * s.sky.h;
        F x = u1 * float(count);
        I cell = to_int(x);
        cell = inside(cell, count);
        // What is left of u1 is too coarse to be used again: u0 decides where the choice between lights does not need it.
        F v0 = s.light_count ? rng.next() : u0;
        const float* alias = s.sky.alias.data();
        cell = v0 < gather(alias, cell * 2) ? cell : (I)gather(alias + 1, cell * 2);
        F row = floor_((to_float(cell) + 0.5f) / float(s.sky.w)), column = to_float(cell) - row * float(s.sky.w);
        F u = (column + u2) / float(s.sky.w), v = (row + rng.next()) / float(s.sky.h), su, cu, sv, cv;
        turn(u, su, cu), turn(0.5f * v, sv, cv);
        Look sky = sky_at(s.sky, u, v, sv);
        to = {sv * su, cv, -sv * cu}, radiance = sky.radiance, light_pdf = sky.pdf * s.environment_choice;
    }
    if (bits(~to_sky)) {
        F u = (u0 - s.environment_choice) / (1.0f - s.environment_choice);
        I low = {}, high = I{} + (s.light_count - 1);
        for (int span = s.light_count; span > 1; span = (span + 1) / 2) {
            I middle = (low + high) >> 1, above = gather(s.cdf.data(), middle) <= u;
            low = above ? middle + 1 : low, high = above ? high : middle;
        }
        low = low > high ? high : low;
        auto column = [&](int k) { return gather(s.lights[k].data(), low); };
        F r = root(u1), b1 = r * (1.0f - u2), b2 = r * u2;
        V q = {column(0) + b1 * column(3) + b2 * column(6), column(1) + b1 * column(4) + b2 * column(7),
               column(2) + b1 * column(5) + b2 * column(8)};
        V way = q - p;
        F d2 = max(dot(way, way), splat(1e-30f)), distance = root(d2);
        way = way * (1.0f / distance);
        F cosine = -dot(way, {column(9), column(10), column(11)});
        F by_light = cosine > 0 ? column(Scene::CHOICE) * d2 / (cosine * column(Scene::AREA)) : splat(0);
        V l = {column(Scene::L), column(Scene::L + 1), column(Scene::L + 2)};
        to = select(to_sky, to, way), radiance = select(to_sky, radiance, l);
        light_pdf = to_sky ? light_pdf : by_light;
        far = to_sky ? far : distance - s.epsilon;
    }
    V wi = f.local(to), value;
    F bsdf_pdf;
    evaluate<METALS>(material, wo, wi, value, bsdf_pdf);
    V carried = beta * value * radiance * (heuristic(light_pdf, bsdf_pdf) / light_pdf);
    I lit = goes_on & (wi.z > 0) & (light_pdf > 0) & (largest(carried) > 0);
    if (unsigned mask = bits(lit)) {
        int k = w.shadows;
        compress(w.shadow.ox + k, mask, p.x), compress(w.shadow.oy + k, mask, p.y), compress(w.shadow.oz + k, mask, p.z);
        compress(w.shadow.dx + k, mask, to.x), compress(w.shadow.dy + k, mask, to.y), compress(w.shadow.dz + k, mask, to.z);
        compress(w.shadow.far + k, mask, far);
        compress(w.cr + k, mask, carried.x), compress(w.cg + k, mask, carried.y), compress(w.cb + k, mask, carried.z);
        compress((float*)w.owner + k, mask, (F)lanes);
        w.shadows += __builtin_popcount(mask);
    }
    // Material sample and roulette.
    V weight;
    sample<METALS>(material, wo, rng.next(), rng.next(), wi, weight, pdf);
    beta = beta * weight;
    goes_on &= (wi.z > 0) & (largest(beta) > 0);
    bounce += 1;
    I plays = bounce >= 5;
    if (bits(goes_on & plays)) {
        F carries = largest(beta), survival = carries > 1.0f ? splat(1) : min(carries, splat(0.95f));
        goes_on &= ~plays | (rng.next() < survival);
        beta = select(plays, beta * (1.0f / survival), beta);
    }
    V out = f.world(wi);
    store(w.ray.ox + at, p.x), store(w.ray.oy + at, p.y), store(w.ray.oz + at, p.z);
    store(w.ray.dx + at, out.x), store(w.ray.dy + at, out.y), store(w.ray.dz + at, out.z);
    store(w.ray.far + at, splat(1e30f));
    store(w.br + at, beta.x), store(w.bg + at, beta.y), store(w.bb + at, beta.z);
    store(w.lr + at, light.x), store(w.lg + at, light.y), store(w.lb + at, light.z);
    store(w.pdf + at, pdf);
    *(U*)(w.ra + at) = rng.a, *(U*)(w.rb + at) = rng.b;
    *(I*)(w.bounce + at) = goes_on ? bounce : I{} - 1;
}
