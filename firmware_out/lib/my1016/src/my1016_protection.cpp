// Causes and actions of my1016, see my1016_protection.h. Whole numbers only: every target acts at the same samples.
#include "my1016_protection.h"

#include "my1016_platform.h"

my1016_ProtectionState my1016_protection_state;

namespace {

enum : uint8_t { ALARMS, LOST, DEVICE };      // the word of the sample in which a cause shows
enum : uint8_t { BY_ITSELF, BY_COMMAND, BY_COMMAND_ONCE_COOL };  // how an action ends

struct Entry {
    uint32_t mask;       // bits of that word ..
    int32_t restart_mC;  // the part has cooled down below it
    uint16_t delay;      // samples that the cause must have held
    uint8_t word;
    uint8_t least;       // .. and how many of them make the cause
    uint8_t until;
    uint8_t component;   // the part whose cooling is waited for
    uint8_t pwm;         // the largest |PWM| meanwhile
    uint16_t pause;      // samples that it has to act at its second time before a command may end it; twice as many at the next
};

const Entry ENTRIES[MY1016_PROTECTIONS] PROGMEM = {
    // brush_limit: alarm brush_limit: the motor stops; ends by command, once brush is below 110 degC
    {16UL, 110000L, 0u, ALARMS, 1, BY_COMMAND_ONCE_COOL, 0, 0, 0u},
    // bearing_limit: alarm bearing_limit: the motor stops; ends by command, once bearing is below 100 degC
    {32UL, 100000L, 0u, ALARMS, 1, BY_COMMAND_ONCE_COOL, 1, 0, 0u},
    // magnet_limit: alarm magnet_limit: the motor stops; ends by command, once magnet is below 100 degC
    {64UL, 100000L, 0u, ALARMS, 1, BY_COMMAND_ONCE_COOL, 2, 0, 0u},
    // casing_limit: alarm casing_limit: the motor stops; ends by command, once casing is below 100 degC
    {128UL, 100000L, 0u, ALARMS, 1, BY_COMMAND_ONCE_COOL, 3, 0, 0u},
    // sensor_lost: no believed sample of brush or bearing or magnet or casing for 10 s: the motor stops; ends by itself
    {15UL, 0L, 40u, LOST, 1, BY_ITSELF, 0, 0, 0u},
    // sensor_unseen: no believed sample of brush or bearing or magnet or casing since the start: the motor stops; ends by itself
    {1024UL, 0L, 0u, DEVICE, 1, BY_ITSELF, 0, 0, 0u},
    // ambient_lost: the ambient's thermocouple is not believed for 10 s: an event and the LED; ends by itself
    {16UL, 0L, 40u, LOST, 1, BY_ITSELF, 0, 255, 0u},
    // stall: PWM, and the motor does not turn: the motor stops; ends by command, when it came again within 600 s not before 15 s, then twice that, and so on
    {1UL, 0L, 0u, DEVICE, 1, BY_COMMAND, 0, 0, 60u},
    // overspeed: more than 120 % of the nominal speed for 2 s: an event and the LED; ends by itself
    {2UL, 0L, 8u, DEVICE, 1, BY_ITSELF, 0, 255, 0u},
    // turning_without_command: the motor turns at PWM 0 for 60 s: an event and the LED; ends by itself
    {4UL, 0L, 240u, DEVICE, 1, BY_ITSELF, 0, 255, 0u},
    // flash_check: the program in flash is not what was built: the motor stops; ends by command
    {32UL, 0L, 0u, DEVICE, 1, BY_COMMAND, 0, 0, 0u},
    // ram_check: a cell of the RAM does not hold what is written to it: the motor stops; ends by command
    {64UL, 0L, 0u, DEVICE, 1, BY_COMMAND, 0, 0, 0u},
    // cpu_check: a register of the CPU does not hold what is written to it: the motor stops; ends by command
    {2048UL, 0L, 0u, DEVICE, 1, BY_COMMAND, 0, 0, 0u},
    // clock_check: the clock and the watchdog's oscillator disagree: an event and the LED; ends by itself
    {4096UL, 0L, 0u, DEVICE, 1, BY_ITSELF, 0, 255, 0u},
};

const uint32_t LASTING = 7311UL;  // only a command ends them
const uint32_t OPENING = 0UL;  // they open the relay
const uint32_t SHOWING = 16383UL;  // the LED tells of them

const uint16_t FORGOTTEN = 2400;  // samples without an entry after which one of its times is forgotten
const uint8_t MOST_TIMES = 6;      // more are not counted

// What comes again soon has to wait, each time twice as long; what stays away is forgotten bit by bit.
void count_times(uint8_t slot, uint16_t pause, bool acted, bool acts) {
    uint16_t *const left = &my1016_protection_state.left[slot];
    uint8_t *const times = &my1016_protection_state.times[slot];
    if (acts && !acted) {
        const uint32_t grown = *times ? (uint32_t)pause << (*times - 1) : 0;
        *left = grown < 0xFFFFu ? (uint16_t)grown : 0xFFFFu;
        *times = (uint8_t)(*times + (*times < MOST_TIMES));
    } else if (acted && !acts) {
        *left = FORGOTTEN;
    } else if (*left > 0) {
        --*left;
    } else if (!acts && *times > 0) {
        --*times;
        *left = FORGOTTEN;
    }
}

bool is_there(const Entry &entry, const my1016_Conditions *conditions) {
    uint32_t bits = entry.word == ALARMS ? conditions->alarms : entry.word == LOST ? conditions->lost : conditions->device;
    uint8_t set = 0;
    for (bits &= entry.mask; bits; bits &= bits - 1) {
        ++set;
    }
    return set >= entry.least;
}

bool may_end(const Entry &entry, uint8_t slot, const my1016_Sample *sample) {
    if (entry.until == BY_ITSELF) {
        return true;
    }
    if (!my1016_protection_state.asked || (entry.pause && my1016_protection_state.left[slot])) {
        return false;
    }
    return entry.until == BY_COMMAND ||
           (((sample->valid >> entry.component) & 1u) && sample->measured_mC[entry.component] < entry.restart_mC);
}

}  // namespace

extern "C" void my1016_protection_begin(void) { my1016_protection_state = my1016_ProtectionState(); }

extern "C" void my1016_protection_restore(uint32_t acting) { my1016_protection_state.acting |= acting & LASTING; }

extern "C" void my1016_protection_step(const my1016_Conditions *conditions, const my1016_Sample *sample) {
    my1016_ProtectionState *const state = &my1016_protection_state;
    uint8_t slot = 0;  // of the entries that have a pause
    for (uint8_t number = 0; number < MY1016_PROTECTIONS; ++number) {
        const uint32_t bit = (uint32_t)1 << number;
        const bool acted = (state->acting & bit) != 0;
        Entry entry;
        memcpy_P(&entry, &ENTRIES[number], sizeof entry);
        if (!is_there(entry, conditions)) {
            state->held[number] = 0;
            state->holding &= ~bit;
            if (may_end(entry, slot, sample)) {
                state->acting &= ~bit;
            }
        } else {
            state->holding |= bit;
            if (state->held[number] <= entry.delay) {
                ++state->held[number];
            }
            if (state->held[number] > entry.delay) {
                state->acting |= bit;
            }
        }
        if (entry.pause) {
            count_times(slot, entry.pause, acted, (state->acting & bit) != 0);
            ++slot;
        }
    }
    state->asked = 0;
}

extern "C" void my1016_protection_ask(void) { my1016_protection_state.asked = 1; }

extern "C" uint16_t my1016_protection_waiting(void) {
    uint16_t waiting = 0;
    uint8_t slot = 0;
    for (uint8_t number = 0; number < MY1016_PROTECTIONS; ++number) {
        if (pgm_read_word(&ENTRIES[number].pause)) {
            const uint16_t left = my1016_protection_state.left[slot++];
            const bool acts = (my1016_protection_state.acting >> number) & 1u;
            waiting = acts && left > waiting ? left : waiting;
        }
    }
    return waiting;
}

extern "C" uint32_t my1016_protection(void) { return my1016_protection_state.acting; }

extern "C" uint32_t my1016_protection_lasting(void) { return my1016_protection_state.acting & LASTING; }

extern "C" uint8_t my1016_protection_most_pwm(void) {
    uint8_t most = 255;
    for (uint8_t number = 0; number < MY1016_PROTECTIONS; ++number) {
        if ((my1016_protection_state.acting >> number) & 1u) {
            const uint8_t pwm = pgm_read_byte(&ENTRIES[number].pwm);
            most = pwm < most ? pwm : most;
        }
    }
    return most;
}

extern "C" uint8_t my1016_protection_opens_relay(void) { return (my1016_protection_state.acting & OPENING) != 0; }

extern "C" uint8_t my1016_protection_shows(void) { return (my1016_protection_state.acting & SHOWING) != 0; }

static const char name_brush_limit[] PROGMEM = "brush_limit";
static const char name_bearing_limit[] PROGMEM = "bearing_limit";
static const char name_magnet_limit[] PROGMEM = "magnet_limit";
static const char name_casing_limit[] PROGMEM = "casing_limit";
static const char name_sensor_lost[] PROGMEM = "sensor_lost";
static const char name_sensor_unseen[] PROGMEM = "sensor_unseen";
static const char name_ambient_lost[] PROGMEM = "ambient_lost";
static const char name_stall[] PROGMEM = "stall";
static const char name_overspeed[] PROGMEM = "overspeed";
static const char name_turning_without_command[] PROGMEM = "turning_without_command";
static const char name_flash_check[] PROGMEM = "flash_check";
static const char name_ram_check[] PROGMEM = "ram_check";
static const char name_cpu_check[] PROGMEM = "cpu_check";
static const char name_clock_check[] PROGMEM = "clock_check";

extern "C" const char *my1016_protection_name(uint8_t entry) {
    switch (entry) {
        case MY1016_PROTECTION_BEARING_LIMIT:
            return name_bearing_limit;
        case MY1016_PROTECTION_MAGNET_LIMIT:
            return name_magnet_limit;
        case MY1016_PROTECTION_CASING_LIMIT:
            return name_casing_limit;
        case MY1016_PROTECTION_SENSOR_LOST:
            return name_sensor_lost;
        case MY1016_PROTECTION_SENSOR_UNSEEN:
            return name_sensor_unseen;
        case MY1016_PROTECTION_AMBIENT_LOST:
            return name_ambient_lost;
        case MY1016_PROTECTION_STALL:
            return name_stall;
        case MY1016_PROTECTION_OVERSPEED:
            return name_overspeed;
        case MY1016_PROTECTION_TURNING_WITHOUT_COMMAND:
            return name_turning_without_command;
        case MY1016_PROTECTION_FLASH_CHECK:
            return name_flash_check;
        case MY1016_PROTECTION_RAM_CHECK:
            return name_ram_check;
        case MY1016_PROTECTION_CPU_CHECK:
            return name_cpu_check;
        case MY1016_PROTECTION_CLOCK_CHECK:
            return name_clock_check;
        default:
            return name_brush_limit;
    }
}
