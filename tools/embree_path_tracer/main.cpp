// A path tracer on Embree, as a person who knows both would write it in a day: the peer that octolux is timed against.
//
// Paths go in waves of 512 a thread, in structure-of-arrays; every stage runs over 16 lanes with AVX-512, 8 with AVX2;
// ended paths are replaced by new camera paths, so lanes stay full. Embree traces packets of 16 or 8 rays, or single rays,
// whatever `--bounce` and `--shadow` say (tools/peer_embree.py finds the best). The same rules as octolux: one light sample
// and one material sample a vertex, power heuristic, roulette from the fifth event on, `max_bounces` events.
//
// Arguments: SCENE.bin --threads N --spp N --windows N --bounce 1|8|16 --shadow 1|8|16 --isa avx2|avx512 --seed N -o OUT.bin
// SCENE.bin is written by tools/peer_embree.py. Prints a line of JSON.
#include "shade.h"
#include <atomic>
#include <chrono>
#include <pthread.h>
#include <thread>

struct Options {
    int threads = 2, spp = 64, windows = 5, bounce = LANES, shadow = LANES, seed = 1;
    std::string isa = LANES == 16 ? "avx512" : "avx2", out;
};

struct Work { // rows of the film, all samples of a pixel together
    std::atomic<int> row{0};
};

struct Worker {
    const Scene& s;
    const Options& o;
    uint32_t seed;
    std::vector<double>& film;
    Wave& w = *new (std::align_val_t(64)) Wave();
    int x = 0, y = -1, sample = 0;

    // The next camera sample; false where there are no more.
    bool next(Work& work, int& px, uint32_t& key) {
        if (y < 0 || x == s.width) {
            y = work.row++, x = 0, sample = 0;
            if (y >= s.height) return y = -1, false;
        }
        px = y * s.width + x;
        key = (uint32_t(px) * 0x9e3779b9u) ^ hash(seed + uint32_t(sample));
        if (++sample == o.spp) sample = 0, x++;
        return true;
    }

    void refill(Work& work) {
        int first = w.alive;
        while (w.alive < WAVE) {
            int px;
            uint32_t key;
            if (!next(work, px, key)) break;
            int i = w.alive++;
            w.pixel[i] = px, w.bounce[i] = 0, w.ra[i] = hash(key), w.rb[i] = hash(key ^ 0x5bd1e995u) | 1;
        }
        const Camera& c = s.camera;
        for (int at = first & ~(LANES - 1); at < w.alive; at += LANES) {
            I number = numbers() + at;
            unsigned fresh = bits((number >= first) & (number < w.alive));
            Rng rng = {*(U*)(w.ra + at), *(U*)(w.rb + at)};
            I px = *(I*)(w.pixel + at), py = to_int((to_float(px) + 0.5f) / float(s.width));
            F sx = (to_float(px - py * s.width) + rng.next()) * (2.0f / s.width) - 1.0f;
            F sy = 1.0f - (to_float(py) + rng.next()) * (2.0f / s.height);
            V d = unit({c.forward[0] + c.right[0] * sx + c.up[0] * sy, c.forward[1] + c.right[1] * sx + c.up[1] * sy,
                        c.forward[2] + c.right[2] * sx + c.up[2] * sy});
            auto put = [&](float* to, F x) { store(to + at, fresh, x); };
            put(w.ray.ox, splat(c.position[0])), put(w.ray.oy, splat(c.position[1])), put(w.ray.oz, splat(c.position[2]));
            put(w.ray.dx, d.x), put(w.ray.dy, d.y), put(w.ray.dz, d.z), put(w.ray.far, splat(1e30f));
            put(w.br, splat(1)), put(w.bg, splat(1)), put(w.bb, splat(1));
            put(w.lr, splat(0)), put(w.lg, splat(0)), put(w.lb, splat(0)), put(w.pdf, splat(1e30f));
            put((float*)w.ra, (F)rng.a), put((float*)w.rb, (F)rng.b);
        }
        // Debian's Embree asserts on packets of 16 where it runs eight lanes.
        trace(s, w, first, w.alive, o.isa == "avx2" ? 8 : 16, true);
    }

    // Writes what ended to the film, and closes the gaps.
    void compact() {
        int to = 0;
        for (int at = 0; at < w.alive; at += LANES) {
            int count = std::min(LANES, w.alive - at);
            unsigned inside = (1u << count) - 1, keep = bits(*(I*)(w.bounce + at) >= 0) & inside;
            for (unsigned ended = inside & ~keep; ended; ended &= ended - 1) {
                int i = at + __builtin_ctz(ended);
                double* pixel = &film[3 * w.pixel[i]];
                pixel[0] += w.lr[i], pixel[1] += w.lg[i], pixel[2] += w.lb[i];
            }
            if (to != at || keep != inside) {
                float* columns[] = {w.ray.ox, w.ray.oy, w.ray.oz, w.ray.dx, w.ray.dy, w.ray.dz, w.ray.far, w.br, w.bg, w.bb,
                                    w.lr, w.lg, w.lb, w.pdf, (float*)w.ra, (float*)w.rb, (float*)w.pixel, (float*)w.bounce};
                for (float* c : columns) {
                    store(c + to, (1u << __builtin_popcount(keep)) - 1, compress(keep, load(c + at)));
                }
            }
            to += __builtin_popcount(keep);
        }
        w.alive = to;
    }

    void run(Work& work) {
        for (;;) {
            int old = w.alive;
            if (old) trace(s, w, 0, old, o.bounce, false);
            if (old < WAVE) refill(work);
            if (!w.alive) return;
            w.shadows = 0;
            for (int at = 0; at < w.alive; at += LANES) s.conductors ? shade<true>(s, w, at) : shade<false>(s, w, at);
            occlude(s, w, o.shadow);
            compact();
        }
    }
};

int main(int argc, char** argv) {
    _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
    _mm_setcsr(_mm_getcsr() | 0x8040);
    if (argc < 2) return fprintf(stderr, "embree_path_tracer SCENE.bin [options]: see the top of main.cpp\n"), 2;
    Options o;
    for (int i = 2; i + 1 < argc; i += 2) {
        std::string key = argv[i], value = argv[i + 1];
        if (key == "--threads") o.threads = atoi(argv[i + 1]);
        else if (key == "--spp") o.spp = atoi(argv[i + 1]);
        else if (key == "--windows") o.windows = atoi(argv[i + 1]);
        else if (key == "--bounce") o.bounce = atoi(argv[i + 1]);
        else if (key == "--shadow") o.shadow = atoi(argv[i + 1]);
        else if (key == "--seed") o.seed = atoi(argv[i + 1]);
        else if (key == "--isa") o.isa = value;
        else if (key == "-o") o.out = value;
        else return fprintf(stderr, "no option %s\n", argv[i]), 2;
    }
    Scene scene = load_scene(argv[1]);
    commit(scene, o.isa);
    size_t values = 3 * size_t(scene.width) * scene.height;
    std::vector<std::vector<double>> films(o.threads, std::vector<double>(values));
    std::vector<double> rates;
    for (int window = -1; window < o.windows; window++) { // one to warm up
        Work work;
        auto start = std::chrono::steady_clock::now();
        std::vector<std::thread> threads;
        for (int t = 0; t < o.threads; t++)
            threads.emplace_back([&, t] {
                cpu_set_t core;
                CPU_ZERO(&core);
                CPU_SET(t, &core);
                pthread_setaffinity_np(pthread_self(), sizeof core, &core);
                _mm_setcsr(_mm_getcsr() | 0x8040);
                Worker worker{scene, o, hash(uint32_t(o.seed + window + 1)), films[t]};
                worker.run(work);
                operator delete(&worker.w, std::align_val_t(64));
            });
        for (auto& thread : threads) thread.join();
        double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        double paths = double(scene.width) * scene.height * o.spp;
        if (window >= 0) rates.push_back(1e-6 * paths / seconds);
    }
    double samples = double(o.spp) * (o.windows + 1);
    std::vector<float> image(values);
    double mean[3] = {};
    for (size_t i = 0; i < values; i++) {
        double sum = 0;
        for (auto& film : films) sum += film[i];
        image[i] = float(sum / samples);
        mean[i % 3] += sum / samples / (values / 3);
    }
    if (!o.out.empty()) {
        FILE* file = fopen(o.out.c_str(), "wb");
        if (!file || fwrite(image.data(), 4, values, file) != values || fclose(file)) return fprintf(stderr, "cannot write\n"), 2;
    }
    std::sort(rates.begin(), rates.end());
    printf("{\"mpaths_per_s\": %.4f, \"min\": %.4f, \"max\": %.4f, \"samples\": %.0f, \"mean\": [%.8g, %.8g, %.8g]}\n",
           rates[rates.size() / 2], rates[0], rates.back(), samples, mean[0], mean[1], mean[2]);
}
