// Thermal model of my1016: the interface and the order of a sample. See my1016_step.h for the recursion, my1016_schedule.cpp
// for the coefficients.
#include "my1016.h"

#include "my1016_model.h"
#include "my1016_platform.h"

my1016_Model my1016_model;

// In the model's flags only: the coefficients in RAM are those of the last command. Not shown to the user.
static const uint8_t STARTED = 0x80;

// Every rise of the state counts from 30000 thousandths of a degree Celsius, and the ambient is part of what it settles to: so
// its changes pass the part's own dynamics.
static MY1016_SMALL void ambient_words(void) {
    const int32_t over = my1016_model.state.ambient_mK;
    my1016_model.ambient[0] = my1016_word_of(over, 8388L, 39845u, 58196u);
    my1016_model.ambient[1] = my1016_word_of(over, 8388L, 39845u, 58196u);
}

// Another ambient is dealt with as another PWM is, at the next sample.
static void my1016_new_ambient(int32_t thousandths) {
    const int32_t over = thousandths - (30000L);
    if (over != my1016_model.state.ambient_mK) {
        my1016_model.state.ambient_mK = over;
        ambient_words();
        my1016_model.flags &= (uint8_t)~STARTED;
    }
}

// A rise over the ambient as one over the reference; those beyond all ranges stay beyond them.
static int32_t my1016_over_reference(int32_t rise_mK) {
    const int32_t beyond = 1000000000L;
    return (rise_mK > beyond ? beyond : rise_mK < -beyond ? -beyond : rise_mK) + my1016_model.state.ambient_mK;
}

// The ambient's part of what each component settles to.
static inline MY1016_INLINE void add_ambient(my1016_Coefficients *now) {
    const int32_t a = my1016_model.ambient[0];
    now->a[0].steady += a;
    const int32_t b = my1016_model.ambient[1];
    now->b[0].steady += b;
    now->b[1].steady += b;
    now->b[2].steady += b;
}

extern "C" void my1016_channel(uint8_t channel, int32_t thousandths) {
    if (channel == MY1016_CHANNEL_AMBIENT) {
        my1016_new_ambient(thousandths < -10000L ? -10000L : thousandths > 50000L ? 50000L : thousandths);
    }
}

extern "C" void my1016_begin(void) {
    my1016_model.flags = 0;
    my1016_model.state.ambient_mK = 0;
    ambient_words();
    for (uint8_t component = 0; component < MY1016_COMPONENTS; ++component) {
        my1016_start(component, 0);
    }
}

extern "C" MY1016_SMALL void my1016_start(uint8_t component, int32_t rise_mK) {
    rise_mK = my1016_over_reference(rise_mK);
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
    if (rise_mK < -40000L) {
        rise_mK = -40000L;
        flags |= MY1016_START_CLAMPED;
    } else if (rise_mK > 120000L) {
        rise_mK = 120000L;
        flags |= MY1016_START_CLAMPED;
    }
    my1016_rest(x, order, rise_mK, 8388L, 39845u, 58196u);
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

// A new PWM, or the first one: new coefficients.
static inline void change(uint8_t pwm) {
    my1016_Coefficients *const now = &my1016_model.now;
    my1016_schedule(pwm, now);
    add_ambient(now);
}

// A command other than the last one, or the first one. Apart from the step, which would
// save its registers every time otherwise.
static MY1016_ONE_COPY void commanded(int16_t pwm) {
    const uint8_t kept = my1016_model.flags & (STARTED | MY1016_START_CLAMPED | MY1016_SATURATED);
    const uint8_t within = magnitude(pwm);
    my1016_model.command = pwm;
    my1016_model.flags = (uint8_t)(kept | STARTED | pwm_flags(pwm, within));
    change(within);
}

extern "C" void my1016_step(int16_t pwm) {
    if (__builtin_expect(!(my1016_model.flags & STARTED) || pwm != my1016_model.command, 0)) {
        commanded(pwm);
    }
#ifdef __AVR__
    // One sample of everything that cannot saturate, in assembly: registers are saved once, and the time that it takes
    // does not depend on the compiler's options. my1016_step.h has the same in C++ for every other machine.
    //
    // Registers: Z state, Y rates, d r22..r25 times a r18..r21 (see my1016_word.h), r10 components left, r9 runs left.
    __asm__ volatile(
        "push r28\n\tpush r29\n\t"
        // Z: state; Y: coefficients.
        "ldi r30, lo8(%[state])\n\tldi r31, hi8(%[state])\n\tldi r28, lo8(%[now])\n\tldi r29, hi8(%[now])\n\t"
        // ---- brush ----
        ".LqA%=:\n\t"
        // d = x1.hi - S
        "ldd r22, Z+2\n\tldd r23, Z+3\n\tldd r24, Z+4\n\tldd r25, Z+5\n\tldd r0, Y+12+0\n\tsub r22, r0\n\t"
        "ldd r0, Y+12+1\n\tsbc r23, r0\n\tldd r0, Y+12+2\n\tsbc r24, r0\n\tldd r0, Y+12+3\n\tsbc r25, r0\n\t"
        // a = R0
        "ldd r18, Y+0\n\tldd r19, Y+1\n\tldd r20, Y+2\n\tldd r21, Y+3\n\t"
        // product, from bit 32 on
        "clr r11\n\t"
        MY1016_PRODUCT_6
        // d < 0: less a * 2^32
        "sbrs r25, 7\n\trjmp 1f\n\tsub r16, r18\n\tsbc r17, r19\n\tsbc r15, r20\n\tsbc r13, r21\n\t1:\n\t"
        // d = x2.hi + product
        "ldd r22, Z+8\n\tadd r22, r16\n\tldd r23, Z+9\n\tadc r23, r17\n\tldd r24, Z+10\n\tadc r24, r15\n\t"
        "ldd r25, Z+11\n\tadc r25, r13\n\t"
        // a = R1
        "ldd r18, Y+4\n\tldd r19, Y+5\n\tldd r20, Y+6\n\tldd r21, Y+7\n\t"
        // product, from bit 32 on
        MY1016_PRODUCT_3
        // d < 0: less a * 2^32
        "sbrs r25, 7\n\trjmp 1f\n\tsub r16, r18\n\tsbc r17, r19\n\tsbc r15, r20\n\tsbc r13, r21\n\t1:\n\t"
        // d = x3.hi + product
        "ldd r22, Z+14\n\tadd r22, r16\n\tldd r23, Z+15\n\tadc r23, r17\n\tldd r24, Z+16\n\tadc r24, r15\n\t"
        "ldd r25, Z+17\n\tadc r25, r13\n\t"
        // a = R2
        "ldd r18, Y+8\n\tldd r19, Y+9\n\tldd r20, Y+10\n\tldd r21, Y+11\n\t"
        // product, from bit 24 on
        MY1016_PRODUCT_3
        // d < 0: less a * 2^32
        "sbrs r25, 7\n\trjmp 1f\n\tsub r16, r18\n\tsbc r17, r19\n\tsbc r15, r20\n\tsbc r13, r21\n\tsbc r11, r11\n\t"
        "1:\n\t"
        // r21: 4/3 of R2's uppermost byte
        "ldi r22, 172\n\tfmul r21, r22\n\tmov r21, r1\n\t"
        // x3 += q; its bytes 1 to 5 stay in r26, r27, r14, r18, r19
        "ldd r0, Z+12\n\tsub r0, r27\n\tstd Z+12, r0\n\tldd r26, Z+13\n\tsbc r26, r16\n\tstd Z+13, r26\n\t"
        "ldd r27, Z+14\n\tsbc r27, r17\n\tstd Z+14, r27\n\tldd r14, Z+15\n\tsbc r14, r15\n\tstd Z+15, r14\n\t"
        "ldd r18, Z+16\n\tsbc r18, r13\n\tstd Z+16, r18\n\tldd r19, Z+17\n\tsbc r19, r11\n\tstd Z+17, r19\n\t"
        // r22:r23 = x3 >> 33, and R0's byte times x2's
        "movw r22, r18\n\tasr r23\n\tror r22\n\tldd r20, Z+11\n\tldd r17, Y+3\n\tswap r17\n\tandi r17, 15\n\t"
        "mulsu r20, r17\n\tadd r22, r0\n\tadc r23, r1\n\t"
        // r16:r17 = that times R1's byte
        "ldd r20, Y+7\n\tmulsu r23, r20\n\tmovw r16, r0\n\tmul r22, r20\n\tclr r11\n\tadd r16, r1\n\t"
        "adc r17, r11\n\t"
        // and 2 q: the change of q
        "lsl r15\n\trol r13\n\tsub r16, r15\n\tsbc r17, r13\n\t"
        // d in r24:r25 and its sign r22 = that times r21, >> 7
        "mulsu r17, r21\n\tsbc r22, r22\n\tmovw r24, r0\n\tmul r16, r21\n\tadd r24, r1\n\tadc r25, r11\n\t"
        "adc r22, r11\n\tlsl r0\n\trol r24\n\trol r25\n\t"
        // >> 10
        "asr r19\n\tror r18\n\tror r14\n\tror r27\n\tror r26\n\tasr r19\n\tror r18\n\tror r14\n\tror r27\n\t"
        "ror r26\n\tmov r12, r19\n\tlsl r12\n\tsbc r12, r12\n\t"
        // x3 >> 10 and d
        "add r26, r24\n\tadc r27, r25\n\tadc r14, r22\n\tadc r18, r22\n\tadc r19, r22\n\tadc r12, r22\n\t"
        // x2
        "ldd r20, Z+6\n\tldd r21, Z+7\n\tldd r22, Z+8\n\tldd r23, Z+9\n\tldd r24, Z+10\n\tldd r25, Z+11\n\t"
        // x2 again
        "mov r15, r21\n\tmovw r16, r22\n\tmovw r0, r24\n\t"
        // >> 13
        "mov r11, r1\n\tlsl r11\n\tsbc r11, r11\n\tmov r13, r11\n\tlsl r15\n\trol r16\n\trol r17\n\trol r0\n\t"
        "rol r1\n\trol r13\n\tlsl r15\n\trol r16\n\trol r17\n\trol r0\n\trol r1\n\trol r13\n\tlsl r15\n\trol r16\n\t"
        "rol r17\n\trol r0\n\trol r1\n\trol r13\n\t"
        // x1 += x2 >> 13
        "ldd r15, Z+0+0\n\tadd r15, r16\n\tstd Z+0+0, r15\n\tldd r15, Z+0+1\n\tadc r15, r17\n\tstd Z+0+1, r15\n\t"
        "ldd r15, Z+0+2\n\tadc r15, r0\n\tstd Z+0+2, r15\n\tldd r15, Z+0+3\n\tadc r15, r1\n\tstd Z+0+3, r15\n\t"
        "ldd r15, Z+0+4\n\tadc r15, r13\n\tstd Z+0+4, r15\n\tldd r15, Z+0+5\n\tadc r15, r11\n\tstd Z+0+5, r15\n\t"
        // x2 += x3 >> 10 and d
        "add r20, r26\n\tstd Z+6+0, r20\n\tadc r21, r27\n\tstd Z+6+1, r21\n\tadc r22, r14\n\tstd Z+6+2, r22\n\t"
        "adc r23, r18\n\tstd Z+6+3, r23\n\tadc r24, r19\n\tstd Z+6+4, r24\n\tadc r25, r12\n\tstd Z+6+5, r25\n\t"
        // The next component.
        "adiw r30, 18\n\tadiw r28, 16\n\t"
        // ---- bearing, magnet, casing ----
        // Each component.
        ".LcB%=:\n\t"
        // a = R0
        "ld r18, Y+\n\tld r19, Y+\n\tld r20, Y+\n\tld r21, Y+\n\t"
        // d = x1.hi - S
        "ldd r22, Z+2\n\tldd r23, Z+3\n\tldd r24, Z+4\n\tldd r25, Z+5\n\tld r0, Y+\n\tsub r22, r0\n\tld r0, Y+\n\t"
        "sbc r23, r0\n\tld r0, Y+\n\tsbc r24, r0\n\tld r0, Y+\n\tsbc r25, r0\n\t"
        // product, from bit 24 on
        "clr r11\n\t"
        MY1016_PRODUCT_3
        // d < 0: less a * 2^32
        "sbrs r25, 7\n\trjmp 1f\n\tsub r16, r18\n\tsbc r17, r19\n\tsbc r15, r20\n\tsbc r13, r21\n\tsbc r11, r11\n\t"
        "1:\n\t"
        // x1 += q
        "ld r0, Z\n\tsub r0, r27\n\tst Z+, r0\n\tld r0, Z\n\tsbc r0, r16\n\tst Z+, r0\n\tld r0, Z\n\tsbc r0, r17\n\t"
        "st Z+, r0\n\tld r0, Z\n\tsbc r0, r15\n\tst Z+, r0\n\tld r0, Z\n\tsbc r0, r13\n\tst Z+, r0\n\tld r0, Z\n\t"
        "sbc r0, r11\n\tst Z+, r0\n\t"
        "cpi r30, lo8(%[state]+36)\n\tbreq 1f\n\trjmp .LcB%=\n\t1:\n\t"
        // The compiler wants r1 = 0.
        "9:\n\tpop r29\n\tpop r28\n\tclr r1\n\t"
        :
        : [state] "i"(my1016_model.state.a), [now] "i"(my1016_model.now.a)
        : "r0", "r1", "r11", "r12", "r13", "r14", "r15", "r16", "r17", "r18", "r19", "r20", "r21", "r22", "r23", "r24", "r25", "r26", "r27", "r30", "r31", "memory");
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
    ambient_words();
    add_ambient(&my1016_model.now);
}

extern "C" int32_t my1016_rise_mK(uint8_t component) {
    switch (component) {
        case MY1016_BRUSH:
            return my1016_A_rise_mK(&my1016_model.state.a[0]) - my1016_model.state.ambient_mK;
        case MY1016_BEARING:
            return my1016_B_rise_mK(&my1016_model.state.b[0]) - my1016_model.state.ambient_mK;
        case MY1016_MAGNET:
            return my1016_B_rise_mK(&my1016_model.state.b[1]) - my1016_model.state.ambient_mK;
        case MY1016_CASING:
            return my1016_B_rise_mK(&my1016_model.state.b[2]) - my1016_model.state.ambient_mK;
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
