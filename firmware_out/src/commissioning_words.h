// What commissioning says: its steps, what may go wrong in them, and the words for both.
#ifndef COMMISSIONING_WORDS_H
#define COMMISSIONING_WORDS_H

#include <stdint.h>

namespace commissioning {

// Its steps, in their order; WARM and LET_GO are gone through for each thermocouple, RUN to ASK for each direction.
enum Phase : uint8_t { IDLE, COLD, WARM, LET_GO, ARM, RUN, STOP, ASK, OFFER, KEEP };

enum Failure : uint8_t {
    NONE,
    UNREAD,    // a thermocouple is not believed, or not even read
    APART,     // two of them are too far apart for a cold motor
    UNSTEADY,  // one of them moves
    WARMER,    // another one than the one that was asked for
    COLDER,    // one that somebody warms
    WAITED,    // the person's time is over
    ALARM,
    DRIVEN,    // by somebody else
    ENDED,     // by another command
    STOPPED,   // by what protects
    WRONG_WAY,
    SILENT,    // no pulse
    NOISY,     // more pulses than the motor can give
    TURNED,    // pulses before the motor was driven
    TURNS_ON,  // pulses after it was stopped
    UNWRITTEN  // the record in EEPROM
};

const uint8_t NOBODY = 0xFF;

// An instruction, that it was passed (IDLE), or why it failed.
struct Words {
    Phase phase;      // that goes on, or that failed
    Failure failure;  // NONE: none
    uint8_t asked;    // the thermocouple that is to be warmed
    uint8_t culprit;  // the one that failed, or NOBODY
    uint16_t figure;  // counts of 250 mK, or revolutions a minute
    bool reverse;
};

// One line, as an event.
void put(const Words &words);

}  // namespace commissioning

#endif
