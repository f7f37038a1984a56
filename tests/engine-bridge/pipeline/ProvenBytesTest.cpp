// What a cap has proven is what is sent, to the byte.
#include "engine-bridge/pipeline/HologramPipeline.h"
#include "tests/Eventually.h"
#include "tests/engine-bridge/pipeline/Fakes.h"

#include <complex>
#include <cstdint>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::bridge;

namespace
{

using Bytes = std::vector<std::uint8_t>;

Bytes bytesOf(const device::DriveSignal& signal)
{
    Bytes bytes = signal.phase;
    bytes.insert(bytes.end(), signal.duty.begin(), signal.duty.end());
    return bytes;
}

struct ByteLog
{
    std::mutex mutex;
    std::set<Bytes> proven; ///< the device was asked what it would play of them
    std::vector<Bytes> sent;
    int unproven = 0; ///< of those that were sent
};

/// A simulation that keeps the bytes that it is asked about, and those that it gets.
class ByteRecorder : public device::ArrayDevice
{
public:
    ByteRecorder(ByteLog& log, std::unique_ptr<device::ArrayDevice> device) :
        _log(log),
        _device(std::move(device))
    {
    }
    bool send(const device::DriveSignal& signal) override
    {
        const std::lock_guard<std::mutex> lock(_log.mutex);
        _log.sent.push_back(bytesOf(signal));
        _log.unproven += _log.proven.count(bytesOf(signal)) > 0 ? 0 : 1;
        return _device->send(signal);
    }
    void silence() override { _device->silence(); }
    bool setAmplitudeCap(double cap) override { return _device->setAmplitudeCap(cap); }
    std::string status() const override { return _device->status(); }
    device::DeviceReport report() const override { return _device->report(); }
    device::DriveAbility ability() const override
    {
        device::DriveAbility ability = _device->ability();
        ability.sequenceFields = 0;
        return ability;
    }
    std::vector<std::complex<float>> played() const override { return _device->played(); }
    std::vector<std::complex<float>> wouldPlay(const device::DriveSignal& signal) const override
    {
        const std::lock_guard<std::mutex> lock(_log.mutex);
        _log.proven.insert(bytesOf(signal));
        return _device->wouldPlay(signal);
    }

private:
    ByteLog& _log;
    const std::unique_ptr<device::ArrayDevice> _device;
};

/// What the recorder gets of a square under a cap of \a share of its pressure.
void recordSquare(const std::string& board, bool inTurn, double share, ByteLog& log)
{
    HologramOptions options;
    options.array = board.empty() ? haptics::TransducerArray::octagonalPrism()
                                  : haptics::TransducerArray::load(board);
    options.deviceUri = board.empty() ? "sim:" : "sim:?board=" + board;
    options.subsets = inTurn ? 3 : 1;
    SceneSnapshot snapshot = squareSnapshot();
    if (!board.empty())
        snapshot.objects[0].pose.translation() =
            options.array.positions.rowwise().mean() + 0.12 * options.array.normals.col(0);
    options.maxPressure =
        share * HologramPipeline(options).process(snapshot)->achieved_Pa.maxCoeff();
    const std::string uri = options.deviceUri;
    options.deviceFactory = [&log, uri](const std::string&, const device::DeviceLayout& layout)
    { return std::make_unique<ByteRecorder>(log, device::openDevice(uri, layout)); };
    options.array.mark("3, 20-25", "");
    HologramPipeline pipeline(options);
    const auto result = pipeline.process(snapshot);
    EXPECT_LT(result->report().capFactor, 1.0);
    const auto sent = [&]
    {
        const std::lock_guard<std::mutex> lock(log.mutex);
        return log.sent.size();
    };
    EXPECT_TRUE(eventually([&] { return sent() >= (inTurn ? 6U : 1U); }));
    pipeline.silence();
}

} // namespace

// Or what is proven would be another field than what sounds.
TEST(CappedPipeline, TheBytesThatAreProvenAreTheBytesThatAreSent)
{
    for (const char* const board : {"", "sonicsurface"})
        for (const bool inTurn : {false, true})
            for (const double share : {0.9, 0.3, 0.1})
            {
                const std::string name =
                    std::string(board) + (inTurn ? " in turn " : " held ") + std::to_string(share);
                ByteLog log;
                recordSquare(board, inTurn, share, log);
                EXPECT_FALSE(log.sent.empty()) << name;
                EXPECT_EQ(log.unproven, 0) << name;
                for (const Bytes& bytes : log.sent)
                {
                    const std::size_t m = bytes.size() / 2;
                    for (const std::size_t dead : {3, 20, 25})
                        EXPECT_EQ(bytes[m + dead], 0) << name;
                }
            }
}
