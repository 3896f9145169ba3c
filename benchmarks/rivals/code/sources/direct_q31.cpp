// (d) The same in Q31, as textbooks and DSP libraries port it: 64-bit products, shifted right by 31.
//
// Rises are parts of 512 K, the input is parts of 256 counts; the coefficients are quartered, so that -3 fits.
#include "rival.h"

struct Third {
    int32_t a[3], b[3];
};
struct First {
    int32_t a, b;
};
#include "direct_q31_table.h" // BRUSH[256], OTHERS[256][3]

static int32_t y[3], u[3]; // the brush's last outputs and inputs, newest first

static int32_t word(const int32_t *place) {
    return static_cast<int32_t>(pgm_read_dword(place));
}

static int32_t product(int32_t a, int32_t b) {
    return static_cast<int32_t>((static_cast<int64_t>(a) * b) >> 31);
}

// The quartered sum times four, held to the range.
static int32_t unscaled(int32_t sum) {
    if (sum > INT32_MAX / 4) {
        return INT32_MAX;
    }
    if (sum < INT32_MIN / 4) {
        return INT32_MIN;
    }
    return sum * 4;
}

void rival_begin() {
    for (uint8_t i = 0; i < 3; ++i) {
        y[i] = u[i] = 0;
    }
    for (uint8_t i = 0; i < RIVAL_PARTS; ++i) {
        rival_rise[i] = 0;
    }
}

void rival_step(int16_t pwm) {
    const int16_t magnitude = rival_magnitude(pwm);
    u[2] = u[1];
    u[1] = u[0];
    u[0] = static_cast<int32_t>(magnitude) << 23;
    const Third *row = &BRUSH[magnitude];
    int32_t sum = 0;
    for (uint8_t k = 0; k < 3; ++k) {
        sum += product(word(&row->b[k]), u[k]) - product(word(&row->a[k]), y[k]);
    }
    y[2] = y[1];
    y[1] = y[0];
    y[0] = rival_rise[0] = unscaled(sum);
    for (uint8_t i = 0; i < 3; ++i) {
        const First *other = &OTHERS[magnitude][i];
        rival_rise[i + 1] = unscaled(product(word(&other->b), u[0]) - product(word(&other->a), rival_rise[i + 1]));
    }
}
