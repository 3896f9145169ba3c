// What RAM keeps through a reset without a loss of power (the watchdog's, the button's, a serial monitor that opens): the model's
// states as of the last sample, the counters of the alarms and of what protects, and which thermocouples were refused.
//
// Two records take turns, a sample each: a reset in mid-write leaves the one before. A record counts only with the right
// identity (coefficients, arithmetic, version, program) and sum.
#ifndef WARM_H
#define WARM_H

#include <stdint.h>

namespace warm {

// Looks for the newest record, and lets what protects go on counting where it was. `firmware` is the CRC of the program in flash.
void begin(uint32_t firmware);

// Lets the model and the alarms go on from the newest record if the measured temperatures are where they were; false if
// there is none or they are not. A thermocouple that was refused then is refused further.
bool resume();

// Once after each sample: keeps what holds now. Some 15 000 cycles.
void keep();

}  // namespace warm

#endif
