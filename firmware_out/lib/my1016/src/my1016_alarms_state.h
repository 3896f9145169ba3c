// What the alarm rules keep in RAM.
#ifndef MY1016_ALARMS_STATE_H
#define MY1016_ALARMS_STATE_H

#include "my1016_alarms.h"

struct my1016_AlarmTimers {
    uint16_t settled;     // samples since PWM entered the rule's range, up to its settling time
    uint16_t start_wait;  // samples still to wait after a start whose slopes are not known
    uint16_t held;        // samples that the condition has held, up to one more than its persistence
    int32_t sum;          // a CUSUM's sum, in thousandths of a kelvin times samples
};

struct my1016_AlarmState {
    my1016_AlarmTimers timers[MY1016_ALARMS];
    uint16_t latched, active, asleep;
};

extern my1016_AlarmState my1016_alarm_state;

#endif
