// The model in another sketch: three lines.
#include <my1016.h>

void setup() {
    Serial.begin(115200);
    my1016_begin();
}

void loop() {
    my1016_step(255);  // the PWM that acts from now until the next step
    Serial.println(my1016_temperature_mC(MY1016_BRUSH, 30000L));
    delay(MY1016_SAMPLE_MS);
}
