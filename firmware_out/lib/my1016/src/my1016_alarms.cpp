// Alarm rules of my1016, see my1016_alarms.h. Whole numbers only: every target raises the same alarms at the same samples.
#include "my1016_alarms.h"

#include "my1016_alarms_state.h"
#include "my1016_platform.h"

my1016_AlarmState my1016_alarm_state;

// What a rule compares with its threshold.
enum { ABOVE_MODEL, BELOW_MODEL, MEASURED };

static const uint8_t NONE = 255;
static const int32_t AHEAD = 2;        // so many times what a part rose by over two readings is added: what it does in the next 4
static const uint32_t HASTE_MK = 1000;  // with each of these over a limit a sample counts for one more of its persistence

// A range of |PWM| with a threshold, in thousandths of a kelvin (of a degree for MEASURED).
struct Segment {
    uint8_t low, high;  // |PWM|, both included
    int32_t trip;       // the condition begins above it; for a sum: the slack
    int32_t clear;      // and ends at or below it
};

struct Rule {
    uint8_t quantity;
    uint8_t component;
    uint8_t relative_to;      // the component whose deviation from the model is subtracted, or NONE
    uint8_t first, segments;  // in SEGMENTS
    uint8_t requires;         // the rule whose alarm must be raised, or NONE
    uint8_t unless;           // the rule whose alarm must not be raised, or NONE
    uint16_t settle;          // samples since PWM entered the segments
    uint16_t start_wait;      // samples within the segments after a start whose slopes are not known
    uint16_t persistence;     // samples before the alarm
    int32_t sum_limit;        // thousandths of a kelvin times samples; 0: not a sum
    uint8_t ahead;            // 1: it counts what rises as what it will soon be, and waits the less the farther it is passed
};

static const Segment SEGMENTS[] PROGMEM = {
    // fault: $.alarms[0], |PWM| from .speed_percent, then .threshold_K, .hysteresis_K
    {77, 178, 5000L, 4000L},
    // fault_at_rated_speed: $.alarms[1], |PWM| from .speed_percent, then .threshold_K, .hysteresis_K
    {255, 255, 0L, -1000L},
    // bearing_fault: $.alarms[2], |PWM| from .speed_percent, then .threshold_K, .hysteresis_K
    {176, 181, 0L, -1000L},
    // brush_fault: $.alarms[3], |PWM| from .speed_percent, then .threshold_K, .hysteresis_K
    {176, 181, 0L, -1000L},
    // brush_limit: $.alarms[4], |PWM| from .speed_percent, then .limit_degC, .hysteresis_K
    {0, 255, 120000L, 115000L},
    // bearing_limit: $.alarms[5], |PWM| from .speed_percent, then .limit_degC, .hysteresis_K
    {0, 255, 110000L, 105000L},
    // magnet_limit: $.alarms[6], |PWM| from .speed_percent, then .limit_degC, .hysteresis_K
    {0, 255, 110000L, 105000L},
    // casing_limit: $.alarms[7], |PWM| from .speed_percent, then .limit_degC, .hysteresis_K
    {0, 255, 110000L, 105000L},
};

static const Rule RULES[MY1016_ALARMS] PROGMEM = {
    // fault: .settle_s, the wait after a start (from the model's own poles), .persistence_s, in samples of 0.25 s
    {ABOVE_MODEL, MY1016_CASING, NONE, 0, 1, NONE, NONE, 2400u, 0u, 240u, 0L, 0},
    // fault_at_rated_speed: .settle_s, the wait after a start (from the model's own poles), .persistence_s, in samples of 0.25 s
    {ABOVE_MODEL, MY1016_BRUSH, NONE, 1, 1, NONE, NONE, 2400u, 36600u, 240u, 0L, 0},
    // bearing_fault: .settle_s, the wait after a start (from the model's own poles), .persistence_s, in samples of 0.25 s
    {ABOVE_MODEL, MY1016_BRUSH, NONE, 2, 1, 0, NONE, 2400u, 31080u, 240u, 0L, 0},
    // brush_fault: .settle_s, the wait after a start (from the model's own poles), .persistence_s, in samples of 0.25 s
    {BELOW_MODEL, MY1016_BRUSH, NONE, 3, 1, 0, NONE, 2400u, 31080u, 240u, 0L, 0},
    // brush_limit: .settle_s, the wait after a start (from the model's own poles), .persistence_s, in samples of 0.25 s
    {MEASURED, MY1016_BRUSH, NONE, 4, 1, NONE, NONE, 0u, 0u, 4u, 0L, 1},
    // bearing_limit: .settle_s, the wait after a start (from the model's own poles), .persistence_s, in samples of 0.25 s
    {MEASURED, MY1016_BEARING, NONE, 5, 1, NONE, NONE, 0u, 0u, 4u, 0L, 1},
    // magnet_limit: .settle_s, the wait after a start (from the model's own poles), .persistence_s, in samples of 0.25 s
    {MEASURED, MY1016_MAGNET, NONE, 6, 1, NONE, NONE, 0u, 0u, 4u, 0L, 1},
    // casing_limit: .settle_s, the wait after a start (from the model's own poles), .persistence_s, in samples of 0.25 s
    {MEASURED, MY1016_CASING, NONE, 7, 1, NONE, NONE, 0u, 0u, 4u, 0L, 1},
};

// |PWM|; what does not fit a byte is in no segment but the last.
static uint8_t magnitude(int16_t pwm) {
    const uint16_t counts = pwm < 0 ? (uint16_t)(0u - (uint16_t)pwm) : (uint16_t)pwm;
    return (uint8_t)(counts > 255u ? 255u : counts);
}

// The rule's segment at a |PWM|; false if it has none there.
static bool find(const Rule &rule, uint8_t pwm, Segment *segment) {
    for (uint8_t i = 0; i < rule.segments; ++i) {
        memcpy_P(segment, &SEGMENTS[rule.first + i], sizeof *segment);
        if (pwm >= segment->low && pwm <= segment->high) {
            return true;
        }
    }
    return false;
}

// Measured minus model.
static int32_t deviation(uint8_t component, const my1016_Sample *sample) {
    return sample->measured_mC[component] - my1016_temperature_mC(component, sample->ambient_mC);
}

static int32_t compared(const Rule &rule, const my1016_Sample *sample) {
    if (rule.quantity == MEASURED) {
        const int32_t soon = rule.ahead ? AHEAD * sample->rising_mK[rule.component] : 0;
        return sample->measured_mC[rule.component] + soon;
    }
    int32_t above = deviation(rule.component, sample);
    if (rule.relative_to != NONE) {
        above -= deviation(rule.relative_to, sample);
    }
    return rule.quantity == ABOVE_MODEL ? above : -above;
}

static bool raised(uint8_t rule) { return (my1016_alarm_state.latched >> rule) & 1u; }

// A limit of a temperature protects at once, also while a sample is not believed yet: what may be the truth counts.
static bool is_measured(const Rule &rule, const my1016_Sample *sample) {
    if (rule.quantity == MEASURED) {
        return ((sample->valid | sample->plausible) >> rule.component) & 1u;
    }
    return ((sample->valid >> rule.component) & 1u) && (rule.relative_to == NONE || ((sample->valid >> rule.relative_to) & 1u));
}

// Whether the condition holds, given whether it held at the last sample.
static bool holds(const Rule &rule, const Segment &segment, my1016_AlarmTimers *timers, int32_t value) {
    if (rule.sum_limit == 0) {
        return value > (timers->held ? segment.clear : segment.trip);
    }
    // One-sided cumulated sum, kept within 0..sum_limit.
    const int32_t sum = timers->sum + (value - segment.trip);
    timers->sum = sum < 0 ? 0 : sum > rule.sum_limit ? rule.sum_limit : sum;
    return timers->sum == rule.sum_limit;
}

// For how many samples of the rule's persistence this one counts: far over its limit a part has no time left.
static uint32_t counted(const Rule &rule, const Segment &segment, int32_t value) {
    return rule.ahead && value > segment.trip ? 1u + (uint32_t)(value - segment.trip) / HASTE_MK : 1u;
}

// Counts the waiting times; false while the rule sleeps.
static bool awake(const Rule &rule, my1016_AlarmTimers *timers) {
    bool slept = false;
    if (timers->start_wait > 0) {
        --timers->start_wait;
        slept = true;
    }
    if (timers->settled < rule.settle) {
        ++timers->settled;
        slept = true;
    }
    return !slept && (rule.requires == NONE || raised(rule.requires)) && (rule.unless == NONE || !raised(rule.unless));
}

static void evaluate(uint8_t number, int16_t pwm, const my1016_Sample *sample) {
    my1016_AlarmTimers *const timers = &my1016_alarm_state.timers[number];
    const uint16_t bit = (uint16_t)(1u << number);
    Rule rule;
    Segment segment;
    memcpy_P(&rule, &RULES[number], sizeof rule);
    const bool inside = find(rule, magnitude(pwm), &segment);
    if (!inside) {
        timers->settled = 0;
    }
    if (!inside || !awake(rule, timers)) {
        timers->held = 0;
        my1016_alarm_state.active &= (uint16_t)~bit;
        my1016_alarm_state.asleep |= bit;
        return;
    }
    my1016_alarm_state.asleep &= (uint16_t)~bit;
    if (!is_measured(rule, sample)) {
        return;
    }
    const int32_t value = compared(rule, sample);
    if (!holds(rule, segment, timers, value)) {
        timers->held = 0;
        my1016_alarm_state.active &= (uint16_t)~bit;
        return;
    }
    const uint32_t held = timers->held + counted(rule, segment, value);
    timers->held = held > rule.persistence ? (uint16_t)(rule.persistence + 1u) : (uint16_t)held;
    if (timers->held > rule.persistence) {
        my1016_alarm_state.active |= bit;
        my1016_alarm_state.latched |= bit;
    }
}

extern "C" void my1016_alarms_begin(uint8_t trusted) {
    my1016_alarm_state = my1016_AlarmState();
    my1016_alarm_state.asleep = (uint16_t)(255u);
    for (uint8_t rule = 0; rule < MY1016_ALARMS; ++rule) {
        my1016_alarm_state.timers[rule].start_wait = trusted ? 0 : pgm_read_word(&RULES[rule].start_wait);
    }
}

extern "C" void my1016_alarms_restore(uint16_t latched) {
    my1016_alarm_state.latched |= (uint16_t)(latched & 255u);
}

extern "C" void my1016_alarms_step(int16_t pwm, const my1016_Sample *sample) {
    for (uint8_t rule = 0; rule < MY1016_ALARMS; ++rule) {
        evaluate(rule, pwm, sample);
    }
}

extern "C" void my1016_alarms_reset(void) {
    my1016_alarm_state.latched = 0;
    for (uint8_t rule = 0; rule < MY1016_ALARMS; ++rule) {
        // A limit's persistence goes on: else resets in time would keep its alarm away for ever.
        if (pgm_read_byte(&RULES[rule].quantity) != MEASURED) {
            my1016_alarm_state.timers[rule].held = 0;
        }
        my1016_alarm_state.timers[rule].sum = 0;
    }
    my1016_alarm_state.active = 0;
}

extern "C" uint8_t my1016_alarms_over_limit(void) {
    for (uint8_t rule = 0; rule < MY1016_ALARMS; ++rule) {
        if (pgm_read_byte(&RULES[rule].quantity) == MEASURED && my1016_alarm_state.timers[rule].held > 0) {
            return 1;
        }
    }
    return 0;
}

static const char name_fault[] PROGMEM = "fault";
static const char name_fault_at_rated_speed[] PROGMEM = "fault_at_rated_speed";
static const char name_bearing_fault[] PROGMEM = "bearing_fault";
static const char name_brush_fault[] PROGMEM = "brush_fault";
static const char name_brush_limit[] PROGMEM = "brush_limit";
static const char name_bearing_limit[] PROGMEM = "bearing_limit";
static const char name_magnet_limit[] PROGMEM = "magnet_limit";
static const char name_casing_limit[] PROGMEM = "casing_limit";

extern "C" const char *my1016_alarm_name(uint8_t rule) {
    switch (rule) {
        case MY1016_ALARM_FAULT_AT_RATED_SPEED:
            return name_fault_at_rated_speed;
        case MY1016_ALARM_BEARING_FAULT:
            return name_bearing_fault;
        case MY1016_ALARM_BRUSH_FAULT:
            return name_brush_fault;
        case MY1016_ALARM_BRUSH_LIMIT:
            return name_brush_limit;
        case MY1016_ALARM_BEARING_LIMIT:
            return name_bearing_limit;
        case MY1016_ALARM_MAGNET_LIMIT:
            return name_magnet_limit;
        case MY1016_ALARM_CASING_LIMIT:
            return name_casing_limit;
        default:
            return name_fault;
    }
}

extern "C" uint16_t my1016_alarms(void) { return my1016_alarm_state.latched; }

extern "C" uint16_t my1016_alarms_active(void) { return my1016_alarm_state.active; }

extern "C" uint16_t my1016_alarms_asleep(void) { return my1016_alarm_state.asleep; }
