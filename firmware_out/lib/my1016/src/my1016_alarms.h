// Alarm rules of my1016: measured temperatures against the model's, from $.alarms of coeffs.json.
//
// Call my1016_alarms_step() after every my1016_step(). A rule's alarm is latched until my1016_alarms_reset().
#ifndef MY1016_ALARMS_H
#define MY1016_ALARMS_H

#include <stdint.h>

#include "my1016.h"

#ifdef __cplusplus
extern "C" {
#endif

// The rules, in the order of the coefficient file; bit r of a mask is rule r.
enum {
    MY1016_ALARM_FAULT = 0,  // Casing over the model: degreased bearing or broken brush.
    MY1016_ALARM_FAULT_AT_RATED_SPEED = 1,  // Brush over the model at rated speed.
    MY1016_ALARM_BEARING_FAULT = 2,  // Which fault: at 70 % the brush is above the model, so it is the bearing.
    MY1016_ALARM_BRUSH_FAULT = 3,  // Which fault: at 70 % the brush is below the model, so it is the brush.
    MY1016_ALARM_BRUSH_LIMIT = 4,  // Brush too hot: the motor stops.
    MY1016_ALARM_BEARING_LIMIT = 5,  // Bearing too hot: the motor stops.
    MY1016_ALARM_MAGNET_LIMIT = 6,  // Magnet too hot: the motor stops.
    MY1016_ALARM_CASING_LIMIT = 7,  // Casing too hot: the motor stops.
    MY1016_ALARMS = 8
};

// What was measured at the end of a sample, in thousandths of a degree Celsius.
typedef struct {
    int32_t measured_mC[MY1016_COMPONENTS];
    int32_t ambient_mC;  // what the model's rise is added to
    uint16_t valid;      // bit i: component i has a sample that passed its checks
    uint16_t plausible;  // bit i: its sample may be the truth, believed or not; limits of a temperature heed it. All bits of `valid`
                         // belong here too: my1016_alarms_step() takes them so
    uint16_t rising_mK[MY1016_COMPONENTS];  // by how much it rose over the last two readings, beyond what noise is; limits that
                                                // look ahead heed it. 0 where that is not known
} my1016_Sample;

// Clears every alarm and timer. `trusted`: the model's state is right in its slopes too (a cold motor, or a checked
// copy of the state); otherwise rules that need the model wait until a wrong slope can no longer matter.
void my1016_alarms_begin(uint8_t trusted);

// Raises alarms that were latched before a reset of the board, a mask as from my1016_alarms(); bits without a rule are ignored.
void my1016_alarms_restore(uint16_t latched);

// Evaluates every rule after a sample during which `pwm` acted. A component without a valid sample (for a
// limit of its temperature: a plausible one) leaves its rules as they are.
void my1016_alarms_step(int16_t pwm, const my1016_Sample *sample);

// Alarms raised since my1016_alarms_begin() or the last reset.
uint16_t my1016_alarms(void);

// Rules whose condition holds now, and has for the rule's persistence time.
uint16_t my1016_alarms_active(void);

// Rules that are not being evaluated now: PWM outside their range, not settled, or waiting for another rule.
uint16_t my1016_alarms_asleep(void);

// Forgets the alarms raised; a condition that still holds raises its alarm again after the persistence time, and an
// over-temperature that has held for so long at the next sample.
void my1016_alarms_reset(void);

// Whether a measured temperature is over its limit now, for however short.
uint8_t my1016_alarms_over_limit(void);

// A rule's name as in the coefficient file, a string in flash (PROGMEM on the AVR).
const char *my1016_alarm_name(uint8_t rule);

#ifdef __cplusplus
}
#endif

#endif
