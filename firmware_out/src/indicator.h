// The LED and the button.
#ifndef INDICATOR_H
#define INDICATOR_H

#include <stdint.h>

namespace indicator {

// Milliseconds between two calls of update().
const uint8_t SLOT_MS = 32;

void begin();

// What is to be seen: bit r of `alarms` for rule r (its number is r + 1), whether a sensor is faulty, and whether the
// board acts on something that the LED is to tell of.
void show(uint16_t alarms, bool sensor_fault, bool protection);

// Every SLOT_MS: moves the LED's pattern on. True if the button has just been pressed.
bool update();

}  // namespace indicator

#endif
