// What the board of my1016 does when something is wrong: $.protection of coeffs.json, and defaults where that says nothing.
//
// Call my1016_protection_step() after every my1016_alarms_step(), and obey my1016_protection_most_pwm().
#ifndef MY1016_PROTECTION_H
#define MY1016_PROTECTION_H

#include <stdint.h>

#include "my1016.h"
#include "my1016_alarms.h"

#ifdef __cplusplus
extern "C" {
#endif

// The entries; bit p of a mask is entry p.
enum {
    MY1016_PROTECTION_BRUSH_LIMIT = 0,  // alarm brush_limit: the motor stops; ends by command, once brush is below 110 degC
    MY1016_PROTECTION_BEARING_LIMIT = 1,  // alarm bearing_limit: the motor stops; ends by command, once bearing is below 100 degC
    MY1016_PROTECTION_MAGNET_LIMIT = 2,  // alarm magnet_limit: the motor stops; ends by command, once magnet is below 100 degC
    MY1016_PROTECTION_CASING_LIMIT = 3,  // alarm casing_limit: the motor stops; ends by command, once casing is below 100 degC
    MY1016_PROTECTION_SENSOR_LOST = 4,  // no believed sample of brush or bearing or magnet or casing for 10 s: the motor stops; ends by itself
    MY1016_PROTECTION_SENSOR_UNSEEN = 5,  // no believed sample of brush or bearing or magnet or casing since the start: the motor stops; ends by itself
    MY1016_PROTECTION_AMBIENT_LOST = 6,  // the ambient's thermocouple is not believed for 10 s: an event and the LED; ends by itself
    MY1016_PROTECTION_STALL = 7,  // PWM, and the motor does not turn: the motor stops; ends by command, when it came again within 600 s not before 15 s, then twice that, and so on
    MY1016_PROTECTION_OVERSPEED = 8,  // more than 120 % of the nominal speed for 2 s: an event and the LED; ends by itself
    MY1016_PROTECTION_TURNING_WITHOUT_COMMAND = 9,  // the motor turns at PWM 0 for 60 s: an event and the LED; ends by itself
    MY1016_PROTECTION_FLASH_CHECK = 10,  // the program in flash is not what was built: the motor stops; ends by command
    MY1016_PROTECTION_RAM_CHECK = 11,  // a cell of the RAM does not hold what is written to it: the motor stops; ends by command
    MY1016_PROTECTION_CPU_CHECK = 12,  // a register of the CPU does not hold what is written to it: the motor stops; ends by command
    MY1016_PROTECTION_CLOCK_CHECK = 13,  // the clock and the watchdog's oscillator disagree: an event and the LED; ends by itself
    MY1016_PROTECTIONS = 14,
    MY1016_PAUSES = 1  // entries that have to wait when they come again soon
};

// Bits of my1016_Conditions.device: what the sketch itself finds.
enum {
    MY1016_DEVICE_STALL = 1,
    MY1016_DEVICE_OVERSPEED = 2,
    MY1016_DEVICE_TURNING_WITHOUT_COMMAND = 4,
    MY1016_DEVICE_LATE_LOOP = 8,
    MY1016_DEVICE_COMMAND_TIMEOUT = 16,
    MY1016_DEVICE_FLASH_CHECK = 32,
    MY1016_DEVICE_RAM_CHECK = 64,
    MY1016_DEVICE_EEPROM_CHECK = 128,
    MY1016_DEVICE_LIMIT_NEAR = 256,
    MY1016_DEVICE_NOT_COMMISSIONED = 512,
    MY1016_DEVICE_SENSOR_UNSEEN = 1024,
    MY1016_DEVICE_CPU_CHECK = 2048,
    MY1016_DEVICE_CLOCK_CHECK = 4096,
    MY1016_DEVICE_SUPPLY_LOW = 8192
};

// What may be wrong at a sample.
typedef struct {
    uint32_t lost;    // bit i: thermocouple i has no believed sample
    uint16_t alarms;  // my1016_alarms()
    uint16_t device;  // MY1016_DEVICE_..
} my1016_Conditions;

typedef struct {
    uint16_t held[MY1016_PROTECTIONS];  // samples that the cause has held, up to one more than its delay
    uint16_t left[MY1016_PAUSES];    // samples before a command may end it; while it does not act: before a time is forgotten
    uint8_t times[MY1016_PAUSES];    // how often it came that is not forgotten
    uint32_t acting;                        // entries that act
    uint32_t holding;                       // entries whose cause is there, for however long
    uint8_t asked;                          // somebody has asked for the end of what only a command ends
} my1016_ProtectionState;

extern my1016_ProtectionState my1016_protection_state;

void my1016_protection_begin(void);

// Goes on with what acted before a reset of the board, a mask as from my1016_protection_lasting(); other bits are ignored.
void my1016_protection_restore(uint32_t acting);

// Takes a sample.
void my1016_protection_step(const my1016_Conditions *conditions, const my1016_Sample *sample);

// Asks for the end of what only a command ends. It ends at the next sample if its cause is gone by then, and, where
// that is waited for, the part has cooled down.
void my1016_protection_ask(void);

// Samples that have to pass before a command may end all that acts.
uint16_t my1016_protection_waiting(void);

// Entries that act; of them those that only a command ends, which therefore outlive a reset of the board.
uint32_t my1016_protection(void);
uint32_t my1016_protection_lasting(void);

// The largest |PWM| that is allowed: 255 if nothing limits it, 0 if the motor has to stand.
uint8_t my1016_protection_most_pwm(void);

// Whether the motor has to be parted from its supply.
uint8_t my1016_protection_opens_relay(void);

// Whether the LED is to tell of it.
uint8_t my1016_protection_shows(void);

// An entry's name, a string in flash (PROGMEM on the AVR).
const char *my1016_protection_name(uint8_t entry);

#ifdef __cplusplus
}
#endif

#endif
