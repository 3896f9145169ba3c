// Sends every byte back, plus one.
void setup() {
    Serial.begin(115200);
    Serial.println(F("ready"));
}

void loop() {
    int byte_in = Serial.read();
    if (byte_in >= 0) {
        Serial.write(static_cast<uint8_t>(byte_in + 1));
    }
}
