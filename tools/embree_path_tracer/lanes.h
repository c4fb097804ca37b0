// Sixteen lanes with AVX-512, eight with AVX2: GCC's vector types, the functions that shading needs, and a random number
// generator.
#pragma once
#include <immintrin.h>
#include <array>
#include <cstdint>

constexpr int WAVE = 512;
constexpr float PI = 3.14159265358979f;

#ifdef __AVX512DQ__
constexpr int LANES = 16;
#else
#ifndef __AVX2__
#error "this program is written for AVX2 or AVX-512: compile on such a machine with -march=native"
#endif
constexpr int LANES = 8;
#endif
typedef float F __attribute__((vector_size(4 * LANES)));
typedef int I __attribute__((vector_size(4 * LANES)));
typedef unsigned U __attribute__((vector_size(4 * LANES)));

static inline F splat(float x) { return F{} + x; }
static inline F load(const float* p) { return *(const F*)p; }
static inline void store(float* p, F x) { *(F*)p = x; }
static inline F min(F a, F b) { return a < b ? a : b; }
static inline F max(F a, F b) { return a > b ? a : b; }
static inline F abs(F a) { return (F)((I)a & 0x7fffffff); }

#ifdef __AVX512DQ__
static inline I numbers() { return I{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15}; }
static inline F root(F a) { return (F)_mm512_sqrt_ps((__m512)max(a, splat(0))); }
static inline F to_float(I a) { return (F)_mm512_cvtepi32_ps((__m512i)a); }
static inline I to_int(F a) { return (I)_mm512_cvttps_epi32((__m512)a); }
static inline F floor_(F a) { return (F)_mm512_floor_ps((__m512)a); }
static inline F gather(const float* table, I i) { return (F)_mm512_i32gather_ps((__m512i)i, table, 4); }
static inline I gather(const int* table, I i) { return (I)_mm512_i32gather_epi32((__m512i)i, table, 4); }
static inline unsigned bits(I mask) { return _mm512_movepi32_mask((__m512i)mask); }
// The lanes of mask moved to the front, in order.
static inline F compress(unsigned mask, F x) { return (F)_mm512_maskz_compress_ps(mask, (__m512)x); }
// Writes the lanes of mask.
static inline void store(float* p, unsigned mask, F x) { _mm512_mask_storeu_ps(p, mask, (__m512)x); }
// Writes all, wherever that is.
static inline void store_anywhere(float* p, F x) { _mm512_storeu_ps(p, (__m512)x); }
#else
static inline I numbers() { return I{0, 1, 2, 3, 4, 5, 6, 7}; }
static inline F root(F a) { return (F)_mm256_sqrt_ps((__m256)max(a, splat(0))); }
static inline F to_float(I a) { return (F)_mm256_cvtepi32_ps((__m256i)a); }
static inline I to_int(F a) { return (I)_mm256_cvttps_epi32((__m256)a); }
static inline F floor_(F a) { return (F)_mm256_floor_ps((__m256)a); }
static inline F gather(const float* table, I i) { return (F)_mm256_i32gather_ps(table, (__m256i)i, 4); }
static inline I gather(const int* table, I i) { return (I)_mm256_i32gather_epi32(table, (__m256i)i, 4); }
static inline unsigned bits(I mask) { return _mm256_movemask_ps((__m256)mask); }
// Of each mask the numbers of its lanes, a byte each.
static constexpr auto ORDERS = [] {
    std::array<uint64_t, 256> orders{};
    for (unsigned mask = 0; mask < 256; mask++)
        for (unsigned lane = 0, place = 0; lane < 8; lane++)
            if (mask >> lane & 1) orders[mask] |= uint64_t(lane) << (8 * place++);
    return orders;
}();
static inline F compress(unsigned mask, F x) {
    __m256i order = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128((long long)ORDERS[mask]));
    return (F)_mm256_permutevar8x32_ps((__m256)x, order);
}
static inline void store(float* p, unsigned mask, F x) {
    I lanes = ((I{} + int(mask)) & (I{} + 1) << numbers()) != 0;
    _mm256_maskstore_ps(p, (__m256i)lanes, (__m256)x);
}
static inline void store_anywhere(float* p, F x) { _mm256_storeu_ps(p, (__m256)x); }
#endif

struct V {
    F x, y, z;
};
static inline V operator+(V a, V b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
static inline V operator-(V a, V b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
static inline V operator*(V a, F s) { return {a.x * s, a.y * s, a.z * s}; }
static inline V operator*(V a, V b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
static inline F dot(V a, V b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline V cross(V a, V b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
static inline V select(I m, V a, V b) { return {m ? a.x : b.x, m ? a.y : b.y, m ? a.z : b.z}; }
static inline F largest(V a) { return max(a.x, max(a.y, a.z)); }
static inline V unit(V a) { return a * (1.0f / root(dot(a, a))); }

// sin and cos of 2πu, u in [0, 1): a minimax pair on a quarter turn.
static inline void turn(F u, F& s, F& c) {
    F q = floor_(u * 4.0f + 0.5f), x = (u - q * 0.25f) * (2 * PI), x2 = x * x;
    F sine = x * (1.0f + x2 * (-1.6666654611e-1f + x2 * (8.3321608736e-3f + x2 * -1.9515295891e-4f)));
    F cosine = 1.0f + x2 * (-0.5f + x2 * (4.166664568e-2f + x2 * (-1.388731625e-3f + x2 * 2.443315711e-5f)));
    I n = to_int(q), swap = -(n & 1);
    F a = swap ? cosine : sine, b = swap ? sine : cosine;
    s = (-(n & 2)) != 0 ? -a : a;
    c = (-((n + 1) & 2)) != 0 ? -b : b;
}

// atan2 in turns, [0, 1): odd minimax polynomial of degree 15.
static inline F turns_of(F y, F x) {
    F ax = abs(x), ay = abs(y), lo = min(ax, ay), hi = max(max(ax, ay), splat(1e-30f)), t = lo / hi, t2 = t * t;
    F p = t2 * -0.0040540580f + 0.0218612288f;
    p = p * t2 - 0.0559098861f;
    p = p * t2 + 0.0964200441f;
    p = p * t2 - 0.1390853351f;
    p = p * t2 + 0.1994653599f;
    p = p * t2 - 0.3332985605f;
    F a = (p * t2 * t + t) * (0.5f / PI);
    a = ay > ax ? 0.25f - a : a;
    a = x < 0 ? 0.5f - a : a;
    return y < 0 ? 1.0f - a : a;
}

struct Rng {
    U a, b; // xoroshiro64*, Blackman & Vigna
    F next() {
        U r = a * 0x9e3779bbu, c = b ^ a;
        a = ((a << 26) | (a >> 6)) ^ c ^ (c << 9);
        b = (c << 13) | (c >> 19);
        return to_float((I)(r >> 8)) * 0x1p-24f;
    }
};
static inline uint32_t hash(uint32_t x) {
    x ^= x >> 16, x *= 0x7feb352du, x ^= x >> 15, x *= 0x846ca68bu;
    return x ^ x >> 16;
}
