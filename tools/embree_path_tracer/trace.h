// A wave of paths, and Embree on it.
#pragma once
#include "scene.h"

constexpr int PACKET = 16; // the most rays that Embree takes at once

struct Rays { // room for a whole packet beyond the wave
    alignas(64) float ox[WAVE + PACKET], oy[WAVE + PACKET], oz[WAVE + PACKET], dx[WAVE + PACKET], dy[WAVE + PACKET],
        dz[WAVE + PACKET], far[WAVE + PACKET];
};

struct Wave {
    Rays ray, shadow;
    alignas(64) float br[WAVE], bg[WAVE], bb[WAVE], lr[WAVE], lg[WAVE], lb[WAVE], pdf[WAVE];
    alignas(64) unsigned ra[WAVE], rb[WAVE];
    alignas(64) int pixel[WAVE], bounce[WAVE];
    // Hits.
    alignas(64) float nx[WAVE + PACKET], ny[WAVE + PACKET], nz[WAVE + PACKET];
    alignas(64) int prim[WAVE + PACKET];
    // Shadow rays, packed: whose, and what they carry.
    alignas(64) int owner[WAVE + PACKET];
    alignas(64) float cr[WAVE + PACKET], cg[WAVE + PACKET], cb[WAVE + PACKET];
    int shadows = 0, alive = 0;
};

template <int N> struct Packet;
template <> struct Packet<16> {
    typedef RTCRayHit16 RayHit;
    typedef RTCRay16 Ray;
    static void trace(RTCScene s, RTCIntersectContext* c, const int* v, RayHit& r) { rtcIntersect16(v, s, c, &r); }
    static void occluded(RTCScene s, RTCIntersectContext* c, const int* v, Ray& r) { rtcOccluded16(v, s, c, &r); }
};
template <> struct Packet<8> {
    typedef RTCRayHit8 RayHit;
    typedef RTCRay8 Ray;
    static void trace(RTCScene s, RTCIntersectContext* c, const int* v, RayHit& r) { rtcIntersect8(v, s, c, &r); }
    static void occluded(RTCScene s, RTCIntersectContext* c, const int* v, Ray& r) { rtcOccluded8(v, s, c, &r); }
};

template <int N, class R> static void fill(R& r, const Rays& from, int first, float near) {
    memcpy(r.org_x, from.ox + first, 4 * N), memcpy(r.org_y, from.oy + first, 4 * N);
    memcpy(r.org_z, from.oz + first, 4 * N), memcpy(r.dir_x, from.dx + first, 4 * N);
    memcpy(r.dir_y, from.dy + first, 4 * N), memcpy(r.dir_z, from.dz + first, 4 * N);
    memcpy(r.tfar, from.far + first, 4 * N);
    for (int k = 0; k < N; k++) r.tnear[k] = near, r.time[k] = 0, r.mask[k] = ~0u, r.flags[k] = 0;
}

template <int N> static void trace_packets(const Scene& s, Wave& w, int first, int last, bool coherent) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    for (; first < last; first += N) {
        alignas(64) typename Packet<N>::RayHit r;
        alignas(64) int valid[N];
        fill<N>(r.ray, w.ray, first, s.epsilon);
        for (int k = 0; k < N; k++) valid[k] = first + k < last ? -1 : 0, r.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
        Packet<N>::trace(s.rtc, &context, valid, r);
        for (int k = 0; k < N && first + k < last; k++) {
            w.prim[first + k] = r.hit.geomID[k] == RTC_INVALID_GEOMETRY_ID ? -1 : int(r.hit.primID[k]);
            w.ray.far[first + k] = r.ray.tfar[k];
            w.nx[first + k] = r.hit.Ng_x[k], w.ny[first + k] = r.hit.Ng_y[k], w.nz[first + k] = r.hit.Ng_z[k];
        }
    }
}

static void trace_single(const Scene& s, Wave& w, int first, int last) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (int i = first; i < last; i++) {
        RTCRayHit r;
        r.ray = {w.ray.ox[i], w.ray.oy[i], w.ray.oz[i], s.epsilon, w.ray.dx[i], w.ray.dy[i], w.ray.dz[i], 0,
                 w.ray.far[i], ~0u, 0, 0};
        r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(s.rtc, &context, &r);
        w.prim[i] = r.hit.geomID == RTC_INVALID_GEOMETRY_ID ? -1 : int(r.hit.primID);
        w.ray.far[i] = r.ray.tfar;
        w.nx[i] = r.hit.Ng_x, w.ny[i] = r.hit.Ng_y, w.nz[i] = r.hit.Ng_z;
    }
}

static void trace(const Scene& s, Wave& w, int first, int last, int method, bool coherent) {
    if (method == 16) trace_packets<16>(s, w, first, last, coherent);
    else if (method == 8) trace_packets<8>(s, w, first, last, coherent);
    else trace_single(s, w, first, last);
}

// Adds what the shadow rays that get through carry.
template <int N> static void occlude_packets(const Scene& s, Wave& w) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (int first = 0; first < w.shadows; first += N) {
        alignas(64) typename Packet<N>::Ray r;
        alignas(64) int valid[N];
        fill<N>(r, w.shadow, first, s.epsilon);
        for (int k = 0; k < N; k++) valid[k] = first + k < w.shadows ? -1 : 0;
        Packet<N>::occluded(s.rtc, &context, valid, r);
        for (int k = 0; k < N && first + k < w.shadows; k++) {
            int i = w.owner[first + k];
            float clear = r.tfar[k] >= 0 ? 1.0f : 0.0f;
            w.lr[i] += clear * w.cr[first + k], w.lg[i] += clear * w.cg[first + k], w.lb[i] += clear * w.cb[first + k];
        }
    }
}

static void occlude(const Scene& s, Wave& w, int method) {
    if (method == 16) return occlude_packets<16>(s, w);
    if (method == 8) return occlude_packets<8>(s, w);
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (int k = 0; k < w.shadows; k++) {
        const Rays& from = w.shadow;
        RTCRay r = {from.ox[k], from.oy[k], from.oz[k], s.epsilon, from.dx[k], from.dy[k], from.dz[k], 0, from.far[k],
                    ~0u, 0, 0};
        rtcOccluded1(s.rtc, &context, &r);
        int i = w.owner[k];
        if (r.tfar >= 0) w.lr[i] += w.cr[k], w.lg[i] += w.cg[k], w.lb[i] += w.cb[k];
    }
}
