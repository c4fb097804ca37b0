// The scene as tools/peer_embree.py writes it, its lights by power, and the alias table of its sky.
#pragma once
#include "lanes.h"
#include <embree3/rtcore.h>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

struct Camera {
    float position[3], forward[3], right[3], up[3]; // right and up reach to the edges of the film
};

struct Environment {
    int w = 0, h = 0;
    std::vector<float> texels; // R, G, B, and the density of the texel per unit of (u, v): one cache line has it all
    std::vector<float> alias;  // pairs: how often a texel of the alias table is kept, and the one it yields to (as bits)
};

struct Scene {
    int width, height, max_bounces;
    Camera camera;
    std::vector<float> vertices;
    std::vector<int> indices, material, light_of; // light_of: -1 or the light's number
    // Of materials: kind (0 diffuse, 1 conductor), then columns of floats.
    std::vector<int> kind;
    enum { R, G, B, ER, EG, EB, ALPHA, ETA, K = ETA + 3, COLUMNS = K + 3 };
    std::vector<float> table[COLUMNS];
    // Of lights: p0, e1, e2, n, area, choice probability, radiance.
    enum { P0, E1 = 3, E2 = 6, N = 9, AREA = 12, CHOICE, L, LIGHT_COLUMNS = L + 3 };
    std::vector<float> lights[LIGHT_COLUMNS], cdf;
    int light_count = 0;
    float environment_choice = 0, epsilon = 0;
    bool conductors = false;
    Environment sky;
    RTCScene rtc = nullptr;
};

template <class T> static void read(FILE* file, T* to, size_t n) {
    if (fread(to, sizeof(T), n, file) != n) fprintf(stderr, "the scene file is too short\n"), exit(2);
}

static void build_sky(Scene& s) {
    Environment& sky = s.sky;
    int n = sky.w * sky.h;
    std::vector<double> weight(n);
    double sum = 0;
    for (int j = 0; j < sky.h; j++)
        for (int i = 0; i < sky.w; i++) {
            // The look-up is bilinear: a texel's weight is the mean over the cell between centres that it shares.
            double lum = 0;
            for (int dj = -1; dj <= 1; dj++)
                for (int di = -1; di <= 1; di++) {
                    int y = std::clamp(j + dj, 0, sky.h - 1), x = (i + di + sky.w) % sky.w;
                    const float* t = &sky.texels[4 * (y * sky.w + x)];
                    lum += (t[0] + t[1] + t[2]) * (di ? 0.125 : 0.75) * (dj ? 0.125 : 0.75);
                }
            sum += weight[j * sky.w + i] = lum * std::sin(PI * (j + 0.5) / sky.h);
        }
    sky.alias.resize(2 * n);
    auto entry = [&](int i, double keep, int other) {
        sky.alias[2 * i] = float(keep), memcpy(&sky.alias[2 * i + 1], &other, 4);
    };
    std::vector<int> small, large;
    std::vector<double> p(n);
    for (int i = 0; i < n; i++) {
        p[i] = weight[i] / sum * n;
        sky.texels[4 * i + 3] = float(p[i]);
        (p[i] < 1 ? small : large).push_back(i);
    }
    while (!small.empty() && !large.empty()) {
        int a = small.back(), b = large.back();
        small.pop_back();
        entry(a, p[a], b);
        p[b] -= 1 - p[a];
        if (p[b] < 1) large.pop_back(), small.push_back(b);
    }
    for (int i : small) entry(i, 1, i);
    for (int i : large) entry(i, 1, i);
    s.environment_choice = float(sum / n * PI); // made a probability with the lights
}

static Scene load_scene(const char* path) {
    FILE* file = fopen(path, "rb");
    if (!file) fprintf(stderr, "%s: cannot open\n", path), exit(2);
    Scene s;
    int head[8]; // width, height, bounces, vertices, triangles, materials, sky width, sky height
    read(file, head, 8);
    s.width = head[0], s.height = head[1], s.max_bounces = head[2];
    read(file, (float*)&s.camera, 12);
    s.vertices.resize(3 * head[3]), s.indices.resize(3 * head[4]), s.material.resize(head[4]), s.kind.resize(head[5]);
    read(file, s.vertices.data(), s.vertices.size());
    read(file, s.indices.data(), s.indices.size());
    read(file, s.material.data(), s.material.size());
    read(file, s.kind.data(), s.kind.size());
    for (auto& column : s.table) column.resize(head[5]), read(file, column.data(), column.size());
    s.sky.w = head[6], s.sky.h = head[7];
    s.sky.texels.resize(4 * size_t(head[6]) * head[7]);
    read(file, s.sky.texels.data(), s.sky.texels.size());
    fclose(file);
    for (int k : s.kind) s.conductors |= k == 1;
    float low[3] = {1e30f, 1e30f, 1e30f}, high[3] = {-1e30f, -1e30f, -1e30f};
    for (size_t i = 0; i < s.vertices.size(); i++)
        low[i % 3] = std::min(low[i % 3], s.vertices[i]), high[i % 3] = std::max(high[i % 3], s.vertices[i]);
    float diagonal2 = 0;
    for (int a = 0; a < 3; a++) diagonal2 += (high[a] - low[a]) * (high[a] - low[a]);
    s.epsilon = 1e-5f * std::sqrt(diagonal2);
    if (s.sky.w) build_sky(s), s.environment_choice *= 0.25f * diagonal2 * PI;
    // Lights by power, π A L.
    s.light_of.assign(head[4], -1);
    std::vector<double> power;
    double sum = 0;
    for (int t = 0; t < head[4]; t++) {
        int m = s.material[t];
        float e[3] = {s.table[Scene::ER][m], s.table[Scene::EG][m], s.table[Scene::EB][m]};
        if (e[0] + e[1] + e[2] <= 0) continue;
        const float *p = &s.vertices[3 * s.indices[3 * t]], *q = &s.vertices[3 * s.indices[3 * t + 1]],
                    *r = &s.vertices[3 * s.indices[3 * t + 2]];
        float e1[3], e2[3];
        for (int a = 0; a < 3; a++) e1[a] = q[a] - p[a], e2[a] = r[a] - p[a];
        float n[3] = {e1[1] * e2[2] - e1[2] * e2[1], e1[2] * e2[0] - e1[0] * e2[2], e1[0] * e2[1] - e1[1] * e2[0]};
        float length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        if (length == 0) continue;
        for (int a = 0; a < 3; a++) {
            s.lights[Scene::P0 + a].push_back(p[a]), s.lights[Scene::E1 + a].push_back(e1[a]);
            s.lights[Scene::E2 + a].push_back(e2[a]), s.lights[Scene::N + a].push_back(n[a] / length);
            s.lights[Scene::L + a].push_back(e[a]);
        }
        s.lights[Scene::AREA].push_back(0.5f * length);
        s.light_of[t] = s.light_count++;
        power.push_back(PI * 0.5 * length * (e[0] + e[1] + e[2]));
        sum += power.back();
    }
    double all = sum + s.environment_choice, below = 0;
    s.environment_choice = float(s.environment_choice / all);
    for (double p : power) {
        s.lights[Scene::CHOICE].push_back(float(p / all));
        below += p / sum;
        s.cdf.push_back(float(below));
    }
    if (s.light_count) s.cdf.back() = 2;
    // Gathers of lanes without a light read row 0.
    for (auto& column : s.lights) column.resize(std::max(1, s.light_count));
    s.cdf.resize(std::max(1, s.light_count), 2);
    return s;
}

static void commit(Scene& s, const std::string& isa) {
    std::string config = "threads=2,set_affinity=0,isa=" + isa;
    if (isa == "avx512") config += ",frequency_level=simd512";
    RTCDevice device = rtcNewDevice(config.c_str());
    s.rtc = rtcNewScene(device);
    rtcSetSceneBuildQuality(s.rtc, RTC_BUILD_QUALITY_HIGH);
    RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    void* v = rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, s.vertices.size() / 3);
    void* i = rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, s.indices.size() / 3);
    memcpy(v, s.vertices.data(), s.vertices.size() * 4), memcpy(i, s.indices.data(), s.indices.size() * 4);
    rtcCommitGeometry(mesh);
    rtcAttachGeometry(s.rtc, mesh);
    rtcCommitScene(s.rtc);
}
