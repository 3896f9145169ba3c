#include "board.h"

#include <avr/sleep.h>
#include <avr/wdt.h>

extern uint8_t __heap_start;      // end of the static variables
extern char __data_load_end[];  // end of the program and its constants in flash

namespace board {

namespace {

const uint8_t MARK = 0xA5;
const uint16_t TIMER_US = 4;               // Timer 0 counts every 64 cycles
const uint32_t WINDOW_MS = 600000UL;  // the sleep share is taken over 5 to 10 minutes

const uint16_t RUNNING = 0x5AC3;

uint8_t causes __attribute__((section(".noinit")));     // MCUSR as it was after reset
uint16_t running __attribute__((section(".noinit")));  // RUNNING since the last start, unless the power was off meanwhile
uint32_t slept;          // counts of Timer 0 asleep since `window`
uint32_t window;         // milliseconds
uint16_t earlier_share;  // of the window before

}  // namespace

// Before anything else: after a reset by the watchdog it still runs, with its shortest time.
extern "C" void board_after_reset(void) __attribute__((naked, used, section(".init3")));
void board_after_reset(void) {
    causes = MCUSR;
    MCUSR = 0;
    wdt_disable();
    // The stock boot loader clears MCUSR. After a reset by the watchdog it goes on at once, after any other it first
    // switches the UART on and waits for a second.
    if (causes == 0 && running == RUNNING && !(UCSR0B & _BV(RXEN0))) {
        causes = _BV(WDRF);
    }
}

void begin() {
    wdt_enable(WDTO_2S);
    running = RUNNING;
    // The Arduino core lets all PWM timers and the ADC run.
    TCCR1B = 0;
    TCCR2B = 0;
    TCCR4B = 0;
    TCCR3B = 0;  // runs while its pin carries PWM, see drive.cpp
    ADCSRA = 0;
    ACSR = _BV(ACD);
    PRR0 = _BV(PRTWI) | _BV(PRSPI) | _BV(PRADC) | _BV(PRTIM1) | _BV(PRTIM2);
    PRR1 = _BV(PRUSART1) | _BV(PRUSART2) | _BV(PRUSART3) | _BV(PRTIM4);
    SMCR = _BV(SE);  // sleep is allowed, of the kind idle: timers, UART and EEPROM go on
    window = millis();
    const uint8_t *const stack = reinterpret_cast<const uint8_t *>(SP - 8);
    for (uint8_t *byte = &__heap_start; byte < stack; ++byte) {
        *byte = MARK;
    }
}

const __FlashStringHelper *reset_cause() {
    // Several may be set; power-on sets others too.
    if (causes & _BV(PORF)) {
        return F("power");
    }
    if (causes & _BV(BORF)) {
        return F("brown-out");
    }
    if (causes & _BV(WDRF)) {
        return F("watchdog");
    }
    if (causes & _BV(EXTRF)) {
        return F("external");
    }
    return F("unknown");  // the boot loader has cleared it
}

bool kept_ram() { return (causes & (_BV(PORF) | _BV(BORF))) == 0; }

void doze(uint32_t until) {
    uint32_t time = millis();
    uint32_t counts = 0;  // in registers: every pulse of the encoder comes by here
    do {
        uint8_t before, after;
        do {
            before = TCNT0;
            sleep_cpu();
            after = TCNT0;
            counts += (uint8_t)(after - before);
            // Pulses of the encoder wake the board too; only an overflow of Timer 0 brings a new millisecond. So long
            // received bytes may wait: at 115200 baud 12, and the core's buffer holds 63. The same count again is a
            // whole turn of the timer, for woken by its overflow alone the board reads it at the same place every time.
        } while (after > before);
        const uint32_t earlier = time;
        time = millis();
        if (after == before && time != earlier) {
            counts += 256;
        }
    } while ((int32_t)(time - until) < 0 && Serial.available() == 0);
    slept += counts;
    if (millis() - window > WINDOW_MS) {
        earlier_share = sleep_share();
        window = millis();
        slept = 0;
    }
}

uint16_t sleep_share() {
    const uint32_t passed = millis() - window;
    return passed < WINDOW_MS / 2 && earlier_share ? earlier_share : (uint16_t)(slept * TIMER_US / (passed ? passed : 1));
}

uint16_t untouched_ram() {
    const uint8_t *byte = &__heap_start;
    while (*byte == MARK && byte < reinterpret_cast<const uint8_t *>(SP)) {
        ++byte;
    }
    return (uint16_t)(byte - &__heap_start);
}

bool ram_holds(uint16_t address) {
    volatile uint8_t *const byte = reinterpret_cast<volatile uint8_t *>(address);
    const uint8_t interrupts = SREG;
    noInterrupts();  // nobody may see what stands there meanwhile
    const uint8_t kept = *byte;
    *byte = 0x55;
    const bool one = *byte == 0x55;
    *byte = 0xAA;
    const bool other = *byte == 0xAA;
    *byte = kept;
    SREG = interrupts;
    return one && other;
}

uint32_t flash_bytes() { return pgm_get_far_address(__data_load_end); }

uint8_t flash_byte(uint32_t address) { return pgm_read_byte_far(address); }

}  // namespace board
