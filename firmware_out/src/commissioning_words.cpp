#include "commissioning_words.h"

#include <Arduino.h>

#include "commands.h"
#include "console.h"
#include "output.h"

namespace commissioning {

namespace {

void put_channel(uint8_t channel) { output::put_name(commands::channel_name(channel)); }

void put_instruction(const Words &words) {
    switch (words.phase) {
        case COLD:
            output::put(F("touch nothing for 10 s"));
            break;
        case WARM:
            output::put(F("warm "));
            put_channel(words.asked);
            output::put(F(" by hand"));
            break;
        case LET_GO:
            put_channel(words.asked);
            output::put(F(" is right, let go"));
            break;
        case ARM:
            output::put(F("keep clear: `arm` drives the motor forward for 4 s"));
            break;
        case RUN:
            output::put(words.reverse ? F("reverse, pwm -51") : F("forward, pwm 51"));
            break;
        case STOP:
            output::put(F("stop"));
            output::put(F(" from "));
            output::put_number(words.figure);
            output::put(F(" rpm"));
            break;
        case ASK:
            output::put(words.reverse ? F("did it turn in reverse? yes or no") : F("did it turn forward? yes or no"));
            break;
        case OFFER:
            output::put(F("keep clear: `yes` drives the motor in reverse, `no` leaves that out"));
            break;
        default:
            output::put(words.phase == KEEP ? F("writing") : F("passed"));
            break;
    }
}

void put_step(const Words &words) {
    switch (words.phase) {
        case COLD:
            output::put(F("cold"));
            break;
        case WARM:
        case LET_GO:
            put_channel(words.asked);
            break;
        case ARM:
        case RUN:
        case STOP:
        case ASK:
        case OFFER:
            output::put(words.reverse ? F("reverse") : F("forward"));
            break;
        default:
            output::put(F("eeprom"));
            break;
    }
}

void put_failure(const Words &words) {
    if (words.culprit != NOBODY) {
        put_channel(words.culprit);
    }
    switch (words.failure) {
        case UNREAD:
            output::put(F(" is not believed"));
            break;
        case APART:
            output::put(F(" is "));
            output::put_thousandths(250L * words.figure, 2);
            output::put(F(" K warmer than another: let it cool"));
            break;
        case UNSTEADY:
            output::put(F(" moves: let it cool"));
            break;
        case WARMER:
            output::put(F(" warmed, not "));
            put_channel(words.asked);
            break;
        case COLDER:
            output::put(F(" got colder: leads exchanged"));
            if (words.culprit != words.asked) {
                output::put(F(", and not "));
                put_channel(words.asked);
            }
            break;
        case WAITED:
            output::put(F("nothing for 120 s"));
            break;
        case ALARM:
            output::put(F("alarm"));
            break;
        case DRIVEN:
            output::put(F("the motor is driven"));
            break;
        case ENDED:
            output::put(F("ended by a line"));
            break;
        case STOPPED:
            output::put(F("the motor has to stand"));
            break;
        case WRONG_WAY:
            output::put(F("the answer is no"));
            break;
        case SILENT:
            output::put(F("no pulse of the encoder"));
            break;
        case NOISY:
            output::put(F("the encoder's line is noisy"));
            break;
        case TURNED:
        case TURNS_ON:
            output::put_number(words.figure);
            output::put(words.failure == TURNED ? F(" rpm before the motor is driven") : F(" rpm 10 s after PWM 0: it does not stop"));
            break;
        default:
            output::put(F("the record does not hold"));
            break;
    }
}

}  // namespace

void put(const Words &words) {
    console::begin_event(F("commissioning"));
    if (words.failure == NONE) {
        output::put(words.phase == IDLE ? F(" ") : F(": "));
        put_instruction(words);
    } else {
        output::put(F(" FAILED at "));
        put_step(words);
        output::put(F(": "));
        put_failure(words);
    }
    output::end_line();
}

}  // namespace commissioning
