// What goes out on the serial line: a run file of rows, events as comment lines between them. Nothing here waits: what does not
// fit is left out and counted, or follows later.
#ifndef CONSOLE_H
#define CONSOLE_H

#include <Arduino.h>

namespace console {

void begin();

// Writes on what is under way: the header, the status, events. False if nothing is left.
bool work();

void begin_status();
void row_every(uint16_t samples);

// Once a sample: a row if it is due, or if PWM, flags, codes or alarms have changed.
void sample();

// An event at the present time: begin_event(), more text with output::put(), output::end_line(). Lost if there is no room.
void begin_event(const __FlashStringHelper *what);
void event(const __FlashStringHelper *what);

// The code of each thermocouple, a digit each.
void put_codes();

}  // namespace console

#endif
