// The model in another sketch: three lines.
#include <my1016.h>

uint32_t due;  // milliseconds, as millis() counts them

void setup() {
    Serial.begin(115200);
    my1016_begin();
    due = millis();
}

void loop() {
    if ((int32_t)(millis() - due) < 0) {
        return;
    }
    due += MY1016_SAMPLE_MS;  // a delay() would add to every sample what the loop itself takes
    my1016_step(255);  // the PWM that acts from now until the next step
    Serial.println(my1016_temperature_mC(MY1016_BRUSH, 30000L));
}
