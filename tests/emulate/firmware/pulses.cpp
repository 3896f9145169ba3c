// Counts rising edges on pin 2 in an interrupt of its own and sleeps; "?" asks for the count.
#include <Arduino.h>

static volatile uint32_t count;

ISR(INT4_vect) {
    ++count;
}

void setup() {
    TCCR1B = TCCR2B = TCCR3B = TCCR4B = TCCR5B = 0;
    ADCSRA = 0;
    Serial.begin(115200);
    EICRB = _BV(ISC41) | _BV(ISC40);
    EIMSK = _BV(INT4);
    SMCR = _BV(SE);
}

void loop() {
    __asm__ __volatile__("sleep");
    if (Serial.read() == '?') {
        noInterrupts();
        const uint32_t now = count;
        interrupts();
        Serial.println(now);
    }
}
