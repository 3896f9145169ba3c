#include <demo_model.h>

demo_model::Model model;

void setup() {
  Serial.begin(115200);
}

void loop() {
  report();
  delay(250);
}

void report() {
  Serial.println(model.step(255));
}
