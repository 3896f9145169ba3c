// Thermal model of my1016: the interface and the order of a sample. See my1016_step.h for the recursion, my1016_schedule.cpp
// for the coefficients.
#include "my1016.h"

#include "my1016_model.h"
#include "my1016_platform.h"

my1016_Model my1016_model;

// In the model's flags only: the coefficients in RAM are those of the last command. Not shown to the user.
static const uint8_t STARTED = 0x80;

extern "C" void my1016_begin(void) {
    my1016_model.flags = 0;
    for (uint8_t component = 0; component < MY1016_COMPONENTS; ++component) {
        my1016_start(component, 0);
    }
}

extern "C" MY1016_SMALL void my1016_start(uint8_t component, int32_t rise_mK) {
    my1016_Word *x;
    uint32_t *rate;
    uint8_t order;
    switch (component) {
        case MY1016_BRUSH:
            x = my1016_model.state.a[0].x;
            rate = my1016_model.now.a[0].rate;
            order = 3;
            break;
        case MY1016_BEARING:
            x = my1016_model.state.b[0].x;
            rate = my1016_model.now.b[0].rate;
            order = 1;
            break;
        case MY1016_MAGNET:
            x = my1016_model.state.b[1].x;
            rate = my1016_model.now.b[1].rate;
            order = 1;
            break;
        case MY1016_CASING:
            x = my1016_model.state.b[2].x;
            rate = my1016_model.now.b[2].rate;
            order = 1;
            break;
        default:
            return;
    }
    // Without coefficients yet nothing drives it: at the next sample, which fetches them in any case, it starts from rest.
    memset(rate, 0, order * sizeof *rate);
    uint8_t flags = my1016_model.flags & (uint8_t)~STARTED;
    if (rise_mK < -60000L) {
        rise_mK = -60000L;
        flags |= MY1016_START_CLAMPED;
    } else if (rise_mK > 160000L) {
        rise_mK = 160000L;
        flags |= MY1016_START_CLAMPED;
    }
    my1016_rest(x, order, rise_mK, 8388L, 39846u);
    my1016_model.flags = flags;
}

// |PWM| within the domain.
static inline uint8_t magnitude(int16_t pwm) {
    const uint16_t counts = pwm < 0 ? (uint16_t)(0u - (uint16_t)pwm) : (uint16_t)pwm;
    return (uint8_t)(counts > 255u ? 255u : counts);
}

// The flags that a PWM brings with it; `within` is its magnitude within the domain.
static inline uint8_t pwm_flags(int16_t pwm, uint8_t within) {
    uint8_t flags = 0;
    if (pwm != within && pwm != -within) {
        flags = MY1016_PWM_CLAMPED;
    }
    if (within < 51u) {
        flags |= MY1016_OUTSIDE_VALIDITY;
    }
    if (within >= 1u && within <= 2u) {
        flags |= MY1016_GAIN_ZEROED;
    }
    return flags;
}

// A new PWM, or the first one: new coefficients, and the part of the state that depends on them.
static void change(uint8_t pwm) {
    my1016_State *const state = &my1016_model.state;
    my1016_Coefficients *const now = &my1016_model.now;
    const int32_t brush_before = my1016_A_drive(&state->a[0], &now->a[0]);
    my1016_schedule(pwm, now);
    my1016_A_carry(&state->a[0], brush_before, my1016_A_drive(&state->a[0], &now->a[0]));
}

// A command other than the last one, or the first one; true if its magnitude is new. Apart from the step, which would
// save its registers every time otherwise.
static MY1016_ONE_COPY uint8_t commanded(int16_t pwm) {
    const uint8_t kept = my1016_model.flags & (STARTED | MY1016_START_CLAMPED | MY1016_SATURATED);
    const uint8_t within = magnitude(pwm);
    const uint8_t changed = within != magnitude(my1016_model.command) || !(kept & STARTED);
    my1016_model.command = pwm;
    my1016_model.flags = (uint8_t)(kept | STARTED | pwm_flags(pwm, within));
    if (changed) {
        change(within);
    }
    return changed;
}

extern "C" void my1016_step(int16_t pwm) {
    if (pwm != my1016_model.command || !(my1016_model.flags & STARTED)) {
        commanded(pwm);
    }
#ifdef __AVR__
    my1016_run(my1016_model.state.a, my1016_model.now.a, 0);
#else
    my1016_A_advance(&my1016_model.state.a[0], &my1016_model.now.a[0]);
    for (uint8_t i = 0; i < 3; ++i) {  // bearing, magnet, casing
        my1016_B_advance(&my1016_model.state.b[i], &my1016_model.now.b[i]);
    }
#endif
}

extern "C" void my1016_resume(int16_t pwm) {
    const uint8_t within = magnitude(pwm);
    my1016_model.command = pwm;
    my1016_model.flags = (uint8_t)(STARTED | pwm_flags(pwm, within));
    my1016_schedule(within, &my1016_model.now);
}

extern "C" int32_t my1016_rise_mK(uint8_t component) {
    switch (component) {
        case MY1016_BRUSH:
            return my1016_A_rise_mK(&my1016_model.state.a[0]);
        case MY1016_BEARING:
            return my1016_B_rise_mK(&my1016_model.state.b[0]);
        case MY1016_MAGNET:
            return my1016_B_rise_mK(&my1016_model.state.b[1]);
        case MY1016_CASING:
            return my1016_B_rise_mK(&my1016_model.state.b[2]);
        default:
            return 0;
    }
}

extern "C" int32_t my1016_temperature_mC(uint8_t component, int32_t ambient_mC) {
    return my1016_rise_mK(component) + ambient_mC;
}

static const char name_brush[] PROGMEM = "brush";
static const char name_bearing[] PROGMEM = "bearing";
static const char name_magnet[] PROGMEM = "magnet";
static const char name_casing[] PROGMEM = "casing";

extern "C" const char *my1016_component_name(uint8_t component) {
    switch (component) {
        case MY1016_BRUSH:
            return name_brush;
        case MY1016_BEARING:
            return name_bearing;
        case MY1016_MAGNET:
            return name_magnet;
        case MY1016_CASING:
            return name_casing;
        default:
            return name_brush;
    }
}

extern "C" uint8_t my1016_flags(void) { return my1016_model.flags & (uint8_t)~STARTED; }

extern "C" uint16_t my1016_saturations(void) { return 0; }
