// The driver of autd3: and the emulator, each written by itself, meet over UDP on this machine.

#include "device/ArrayDevice.h"
#include "tests/Eventually.h"
#include "tests/device/autd3/emulator/ServedUnits.h"

#include <memory>
#include <string>

#include <gtest/gtest.h>

namespace midair::device::emulation
{
namespace
{

/// Skips where this machine has no ::1.
class EmulatedUnitsOverUdp : public ::testing::Test
{
protected:
    void SetUp() override
    {
        try
        {
            _units = std::make_unique<ServedUnits>(2);
        }
        catch (const DeviceError& error)
        {
            GTEST_SKIP() << error.what();
        }
    }

    DriveSignal field() { return _units->field(); }
    ChainReport report() { return _units->report(); }
    /// With time for a busy machine, as in Rehearsal.
    std::string uri() const { return _units->uri() + "&lead=15ms&failsafe=3s"; }

private:
    std::unique_ptr<ServedUnits> _units;
};

TEST_F(EmulatedUnitsOverUdp, play_what_the_driver_is_sent_and_fall_silent_when_it_is_closed)
{
    DriveSignal signal = silentSignal(2 * kUnitTransducers);
    for (int i = 0; i < signal.size(); ++i)
    {
        signal.phase[i] = static_cast<std::uint8_t>(i);
        signal.duty[i] = static_cast<std::uint8_t>(1 + i % 255);
    }
    auto device = openDevice(uri(), {signal.size(), {}});
    EXPECT_TRUE(eventually(
        [&]
        {
            const DriveSignal played = field();
            if (played.phase == signal.phase && played.duty == signal.duty) return true;
            // It is gone where the machine keeps the units from answering.
            if (device->report().pending == 0) device->send(signal);
            return false;
        }))
        << device->status();
    device.reset();
    EXPECT_TRUE(eventually(
        [&] { return field().duty == std::vector<std::uint8_t>(2 * kUnitTransducers); }));
    EXPECT_EQ(report().writesIntoBanks, 0U);
    EXPECT_EQ(report().fields.torn, 0U);
    EXPECT_EQ(report().updateCommands, 0U);
}

TEST_F(EmulatedUnitsOverUdp, an_array_of_another_number_is_refused_by_both_numbers)
{
    const std::string three = uri().replace(uri().find("units=2"), 7, "units=3");
    try
    {
        openDevice(three, {3 * kUnitTransducers, {}});
        FAIL() << "opened";
    }
    catch (const DeviceError& error)
    {
        const std::string text = error.what();
        EXPECT_NE(text.find('2'), std::string::npos) << text;
        EXPECT_NE(text.find("units=3"), std::string::npos) << text;
    }
}

} // namespace
} // namespace midair::device::emulation
