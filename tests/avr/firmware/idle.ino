// Sleeps until millis() has counted 60 s, tells it, and ends. The core's unused PWM timers are stopped.
void setup() {
    TCCR1B = TCCR2B = TCCR3B = TCCR4B = TCCR5B = 0;
    ADCSRA = 0;
    Serial.begin(115200);
    Serial.println(F("start"));
    Serial.flush();
}

void loop() {
    SMCR = _BV(SE);  // idle mode
    __asm__ __volatile__("sleep");
    if (millis() >= 60000UL) {
        Serial.println(millis());
        Serial.flush();
        cli();
        __asm__ __volatile__("sleep");
    }
}
