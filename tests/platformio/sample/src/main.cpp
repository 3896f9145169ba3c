#include <Arduino.h>
#include <demo_model.h>

static demo_model::Model model;

void setup() {
  Serial.begin(115200);
}

void loop() {
  Serial.println(model.step(255));
  delay(250);
}
