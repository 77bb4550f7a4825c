// Front distance sensor of the arm, for any classic Arduino with a VL53L0X or VL53L1X breakout on I2C.
// Sends "$F,sequence,millimetres*hh" 25 times a second; 0 mm stands for no reading.
// Needs the library "VL53L0X" by Pololu. Wiring: VIN-5V, GND-GND, SDA-A4, SCL-A5.

#include <VL53L0X.h>
#include <Wire.h>

VL53L0X sensor;
unsigned int sequence = 0;
bool found = false;

void sendLine(const char *body) {
  byte sum = 0;
  for (const char *p = body; *p; p++) sum ^= (byte)*p;
  char tail[5];
  snprintf(tail, sizeof tail, "*%02X", sum);
  Serial.print('$');
  Serial.print(body);
  Serial.print(tail);
  Serial.print('\n');
}

void setup() {
  Serial.begin(115200);
  Wire.begin();
  sensor.setTimeout(100);
  found = sensor.init();
  if (found) {
    sensor.setMeasurementTimingBudget(33000);
    sensor.startContinuous();
  }
  sendLine("HELLO,pipenav-front,1");
}

void loop() {
  if (!found) return;  // a silent sensor is noticed; invented readings would not be
  unsigned int millimetres = sensor.readRangeContinuousMillimeters();
  if (sensor.timeoutOccurred() || millimetres > 1000) millimetres = 0;
  char body[24];
  snprintf(body, sizeof body, "F,%u,%u", sequence++, millimetres);
  sendLine(body);
  delay(5);
}
