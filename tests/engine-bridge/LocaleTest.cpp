// A decimal comma of the program's locale changes no number, neither read nor written.
#include "engine-bridge/hands/HandSource.h"
#include "tests/CommaLocale.h"
#include "tests/engine-bridge/hands/WrittenHands.h"
#include "tests/engine-bridge/pipeline/Fakes.h"

#include <sstream>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::bridge;

TEST(BridgeLocale, ChangesNoNumberOfAHandRecording)
{
    HandFrame frame;
    frame.time_s = 1234.5;
    frame.hands.emplace_back();
    frame.hands[0].id = 1234;
    frame.hands[0].joints[0].position = Eigen::Vector3d(0.25, -1.5, 0.125);
    frame.hands[0].joints[0].positionValid = true;
    std::ostringstream plain;
    writeHandRecording(plain, {frame});
    const CommaLocale comma;
    if (!comma.isSet()) GTEST_SKIP();
    std::stringstream stream;
    writeHandRecording(stream, {frame});
    EXPECT_EQ(stream.str(), plain.str());
}

TEST(BridgeLocale, ChangesNoNumberOfAMessage)
{
    const CommaLocale comma;
    if (!comma.isSet()) GTEST_SKIP();
    HologramOptions options = fakeOptions(std::make_shared<FakeLog>());
    options.motionTolerance = -0.5;
    std::string error;
    EXPECT_FALSE(options.isValid(&error));
    EXPECT_EQ(error, "motionTolerance is -0.5 wavelengths; it must be within 0 .. 1000");
    options.motionTolerance = 0.0;
    HologramPipeline pipeline(options);
    SceneSnapshot snapshot = squareSnapshot();
    snapshot.objects[0].properties.pressure = -0.5;
    const auto result = pipeline.process(snapshot);
    ASSERT_EQ(result->messages.size(), 1U);
    EXPECT_EQ(result->messages[0],
              "Scene/Square: pressure is -0.5, should be over 0; it can't be felt");
    snapshot.objects[0].properties.pressure = 1.0;
    snapshot.objects[0].properties.modulationFrequency_Hz = 50.5;
    snapshot.objects.push_back(squareSnapshot(0.05).objects[0]);
    snapshot.objects[1].path = "Scene/Second";
    snapshot.objects[1].id = 2;
    snapshot.objects[1].properties.modulationFrequency_Hz = 60.5;
    const std::vector<std::string> messages = pipeline.process(snapshot)->messages;
    EXPECT_EQ(messages.back(),
              "Scene/Second: is modulated at 50.5 Hz like Scene/Square, not at 60.5 Hz: the array "
              "plays one field at a time");
}
