// The core's own pin map, for test_pins.py: port, bit and timer of every pin.
#include <Arduino.h>

void setup() {
    Serial.begin(115200);
    for (uint8_t pin = 0; pin < NUM_DIGITAL_PINS; ++pin) {
        Serial.print(pin);
        Serial.print(' ');
        Serial.print((char)('A' + digitalPinToPort(pin) - 1));
        uint8_t bit = 0;
        while (digitalPinToBitMask(pin) >> bit != 1) {
            ++bit;
        }
        Serial.print(' ');
        Serial.print(bit);
        Serial.print(' ');
        Serial.println(digitalPinToTimer(pin) != NOT_ON_TIMER);
    }
    Serial.println(F("end"));
}

void loop() {}
