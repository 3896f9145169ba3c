// The recursion of each kind of component in fixed point: what one sample does to a state.
//
// x1 is the temperature rise, x2.. its increments over one sample (staggered by half a sample where that saves work).
// q = -R[n-1] (xn + R[n-2] (x[n-1] + .. + R[0] (x1 - S))) drives them; S is the steady rise and R the nested rates of
// the present PWM, from my1016_schedule().
//
// x1 counts from a fixed temperature, and the steady rise that it is drawn to has the ambient over that added.
//
// Adding x3 to x2 is the trapezoidal rule, whose error over a sample is a twelfth of the change of q. Where d appears it
// takes that error away, so that nothing happens to a state when PWM changes: d = R2/12 (q + R1 (x3 + R0 x2)), of which
// one per cent is enough, so it is made of the rates' uppermost bytes.
#ifndef MY1016_STEP_H
#define MY1016_STEP_H

#include "my1016_word.h"

// ---- brush: order 3 ----
//
// brush, proven for every sequence of PWM: rise within -54..121 K,
//   |x2| at most 1.7e-02 K,
//   |x3| at most 1.4e-05 K,
//   and the rise never more than 8.9e-06 K from the exact solution.

struct my1016_A_Rates {
    uint32_t rate[3];  // R0 * 2^45, R1 * 2^42, R2 * 2^40
    int32_t steady;  // S in 2^-23 K, less the middle of what roundings lose
};

struct my1016_A_State {
    my1016_Word x[3];  // x1 in 2^-39 K, x2 in 2^-52 K, x3 in 2^-62 K
};

#ifdef __AVR__
#else

// q in 2^-62 K. Every intermediate is proven to fit its 32 bits.
static inline my1016_Word my1016_A_increment(const my1016_A_State *state, const my1016_A_Rates *now) {
    int32_t inner = state->x[0].hi - now->steady;
    inner = state->x[1].hi + (int32_t)(my1016_product(inner, now->rate[0], 3) >> 32);
    inner = state->x[2].hi + my1016_high32(inner, now->rate[1]);
    my1016_Word q = {0, 0};
    my1016_subtract24(q, inner, now->rate[2]);
    return q;
}

static inline void my1016_A_advance(my1016_A_State *state, const my1016_A_Rates *now) {
    const my1016_Word q = my1016_A_increment(state, now);
    const int32_t x2 = state->x[1].hi >> 24;
    my1016_add(state->x[0], my1016_right13(state->x[1]));
    my1016_add(state->x[2], q);
    my1016_add(state->x[1], my1016_right10(state->x[2]));
    // d, in numbers of 16 bits.
    const int32_t inner = (state->x[2].hi >> 17) + (int32_t)(now->rate[0] >> 28) * x2;
    const int32_t change = (inner * (int32_t)(now->rate[1] >> 24) >> 8) - 2 * (int32_t)(-my1016_whole(q) >> 24);
    const int32_t twelfth = (int32_t)(now->rate[2] >> 24) * 344 >> 8;  // of R2
    my1016_add(state->x[1], my1016_word(change * twelfth >> 7));
}

#endif

// Rise in thousandths of a kelvin, to nearest.
static inline int32_t my1016_A_rise_mK(const my1016_A_State *state) {
    const int32_t high = state->x[0].hi;
    const uint32_t fraction = ((uint32_t)high & 8388607UL);  // in 2^-23 K
    return (high >> 23) * 1000 + (int32_t)((fraction * 125u + 524288UL) >> 20);
}

// ---- bearing, magnet, casing: order 1 ----
//
// bearing, proven for every sequence of PWM: rise within -59..120 K,
//   and the rise never more than 3.8e-06 K from the exact solution.
// magnet, proven for every sequence of PWM: rise within -59..120 K,
//   and the rise never more than 2.0e-06 K from the exact solution.
// casing, proven for every sequence of PWM: rise within -59..120 K,
//   and the rise never more than 1.8e-06 K from the exact solution.

struct my1016_B_Rates {
    uint32_t rate[1];  // R0 * 2^40
    int32_t steady;  // S in 2^-23 K, rounded down
};

struct my1016_B_State {
    my1016_Word x[1];  // x1 in 2^-39 K
};

#ifdef __AVR__
#else

// q in 2^-39 K. Every intermediate is proven to fit its 32 bits.
static inline my1016_Word my1016_B_increment(const my1016_B_State *state, const my1016_B_Rates *now) {
    int32_t inner = state->x[0].hi - now->steady;
    my1016_Word q = {0, 0};
    my1016_subtract24(q, inner, now->rate[0]);
    return q;
}

static inline void my1016_B_advance(my1016_B_State *state, const my1016_B_Rates *now) {
    my1016_add(state->x[0], my1016_B_increment(state, now));
}

#endif

// Rise in thousandths of a kelvin, to nearest.
static inline int32_t my1016_B_rise_mK(const my1016_B_State *state) {
    const int32_t high = state->x[0].hi;
    const uint32_t fraction = ((uint32_t)high & 8388607UL);  // in 2^-23 K
    return (high >> 23) * 1000 + (int32_t)((fraction * 125u + 524288UL) >> 20);
}

#endif
