// With the main thread hung everything else plays on: players, refiners, contacts, drivers. In each
// mode and on each device the hold has to silence it, which is seen at the device's far side.
#include "device/ArrayDevice.h"
#include "device/autd3/emulator/RehearsedAutd3.h"
#include "engine-bridge/extending/ArrayDriver.h"
#include "tests/device/autd3/emulator/ServedUnits.h"
#include "tests/device/boards/BoardEmulator.h"
#include "tests/engine-bridge/playing/HoldTrial.h"

#include <atomic>
#include <cstdio>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <tuple>

#include <gtest/gtest.h>
#include <unistd.h>

using namespace midair;
using holds::Mode;

namespace
{

constexpr const char* kHold = "hold=300ms";

/// What a device's bytes come to, once they have left the kit.
struct FarSide
{
    int transducers = 249;
    holds::Open open;
    std::function<bool()> sounds;
    std::vector<std::shared_ptr<void>> keep;
};

std::string fileOf(const std::string& name)
{
    static std::atomic<int> count{0};
    const auto file = std::filesystem::temp_directory_path() /
                      fmt::format("midair-hold-{}-{}-{}", ::getpid(), ++count, name);
    std::filesystem::remove(file);
    return file;
}

/// Removes its file in the end.
std::shared_ptr<void> removes(const std::string& file)
{
    return {new std::string(file),
            [](void* name)
            {
                std::filesystem::remove(*static_cast<std::string*>(name));
                delete static_cast<std::string*>(name);
            }};
}

holds::Open opening(const std::string& uri)
{
    return [uri](const device::DeviceLayout& layout) { return device::openDevice(uri, layout); };
}

/// Reads a recording while it is written, from Recording.h's description of the format alone.
class GrowingRecording
{
public:
    explicit GrowingRecording(std::string file) : _file(std::move(file)) {}
    ~GrowingRecording()
    {
        if (_stream) std::fclose(_stream);
    }
    GrowingRecording(const GrowingRecording&) = delete;
    GrowingRecording& operator=(const GrowingRecording&) = delete;

    bool sounds()
    {
        if (!_stream) _stream = std::fopen(_file.c_str(), "rb");
        if (!_stream) return false;
        std::clearerr(_stream);
        char part[65536];
        for (std::size_t got = 0; (got = std::fread(part, 1, sizeof part, _stream)) > 0;)
            _bytes.append(part, got);
        while (step())
        {
        }
        return _sounds;
    }

private:
    std::uint32_t number(std::size_t at) const
    {
        std::uint32_t value = 0;
        for (int k = 3; k >= 0; --k)
            value =
                value << 8 | static_cast<unsigned char>(_bytes[at + static_cast<std::size_t>(k)]);
        return value;
    }
    bool step()
    {
        if (!_begun)
        {
            if (_bytes.size() < 32) return false;
            _transducers = number(12);
            _bytes.erase(0, 32);
            _begun = true;
        }
        if (_bytes.size() < 16) return false;
        const std::size_t payload = number(4);
        if (_bytes.size() < 16 + payload + 4) return false;
        const int kind = _bytes[0], phases = _bytes[1], duties = _bytes[2];
        if (kind == 1 && duties != 2) // 2: as in the field before
        {
            const std::size_t from = 16 + (phases == 0 ? _transducers : phases == 1 ? 1 : 0);
            _any = _bytes.substr(from, duties == 0 ? _transducers : 1).find_first_not_of('\0') !=
                   std::string::npos;
        }
        _sounds = kind == 1 && _any;
        _bytes.erase(0, 16 + payload + 4);
        return true;
    }

    const std::string _file;
    std::FILE* _stream = nullptr;
    std::string _bytes;
    std::size_t _transducers = 0;
    bool _begun = false;
    bool _any = false;
    bool _sounds = false;
};

/// What the drivers of this test's devices were told last, by name.
std::atomic<bool>& toldDriver(const std::string& name)
{
    static std::mutex mutex;
    static std::map<std::string, std::atomic<bool>> all;
    const std::lock_guard<std::mutex> lock(mutex);
    return all[name];
}

class ListeningDriver : public bridge::ArrayDriver
{
public:
    bool open(const std::string& path,
              const std::map<std::string, std::string>&,
              const Layout& layout,
              std::string&) override
    {
        _sounds = &toldDriver(path);
        *_sounds = false;
        _transducers = layout.transducers;
        return true;
    }
    bool play(const unsigned char*, const unsigned char* amplitudes) override
    {
        *_sounds = std::any_of(
            amplitudes, amplitudes + _transducers, [](unsigned char one) { return one > 0; });
        return true;
    }
    void silence() override { *_sounds = false; }

private:
    std::atomic<bool>* _sounds = nullptr;
    int _transducers = 0;
};

void registerListening()
{
    static const bool isRegistered = []
    {
        std::string error;
        return bridge::registerDriver(
            "listening", [] { return std::make_shared<ListeningDriver>(); }, error);
    }();
    if (!isRegistered) throw std::runtime_error("\"listening:\" is taken");
}

/// A simulation's far side is within: its firmware takes the packets that hardware would get.
FarSide simulated(const std::string& uri, int transducers)
{
    auto opened = std::make_shared<std::atomic<device::ArrayDevice*>>(nullptr);
    FarSide far;
    far.transducers = transducers;
    far.open = [uri, opened](const device::DeviceLayout& layout)
    {
        auto made = device::openDevice(uri, layout);
        *opened = made.get();
        return made;
    };
    far.sounds = [opened]
    {
        const device::ArrayDevice* const made = *opened;
        if (!made) return false;
        const std::vector<std::complex<float>> q = made->played();
        return std::any_of(
            q.begin(), q.end(), [](std::complex<float> one) { return std::abs(one) > 0.0f; });
    };
    return far;
}

FarSide recorded()
{
    FarSide far;
    const std::string file = fileOf("recorded");
    auto growing = std::make_shared<GrowingRecording>(file);
    far.open = opening("record:" + file + "?" + kHold);
    far.sounds = [growing] { return growing->sounds(); };
    far.keep = {removes(file)};
    return far;
}

FarSide serial()
{
    FarSide far;
    far.transducers = 256;
    auto board =
        std::make_shared<BoardEmulator>("sonicsurface", far.transducers, BoardEmulator::Options());
    board->start();
    far.open = opening("sonicsurface:" + board->name() + "?" + kHold);
    far.sounds = [board] { return !board->silent(); };
    return far;
}

/// What the units make of the datagrams that their sockets got.
FarSide overUdp()
{
    FarSide far;
    auto units = std::make_shared<ServedUnits>(1);
    far.open = opening(units->uri() + "&" + kHold);
    far.sounds = [units]
    {
        const device::DriveSignal field = units->field();
        return std::any_of(
            field.duty.begin(), field.duty.end(), [](std::uint8_t duty) { return duty > 0; });
    };
    return far;
}

FarSide driven(const std::string& name)
{
    registerListening();
    FarSide far;
    far.open = opening("listening:" + name + "?" + kHold);
    far.sounds = [name] { return toldDriver(name).load(); };
    return far;
}

/// Three devices, of which one has the hold: silence in part is none.
FarSide listed(const std::string& name)
{
    registerListening();
    FarSide far;
    const std::string file = fileOf("listed");
    auto growing = std::make_shared<GrowingRecording>(file);
    far.open = opening("record:" + file + ",listening:" + name + ",null:?" + kHold);
    far.sounds = [growing, name] { return growing->sounds() || toldDriver(name); };
    far.keep = {removes(file)};
    return far;
}

FarSide farSideOf(const std::string& device, const std::string& name)
{
    if (device == "sim") return simulated(std::string("sim:?") + kHold, 249);
    if (device == "record") return recorded();
    if (device == "serial") return serial();
    if (device == "autd3") return overUdp();
    if (device == "simulated_autd3")
    {
        device::registerRehearsedAutd3();
        return simulated(std::string("sim:?board=autd3&units=1&") + kHold, 249);
    }
    if (device == "driver") return driven(name);
    return listed(name);
}

class Hold : public testing::TestWithParam<std::tuple<Mode, const char*>>
{
};

TEST_P(Hold, SilencesWhatPlaysByItself)
{
    const auto [mode, device] = GetParam();
    const std::string name = fmt::format("{}-{}", holds::nameOf(mode), device);
    FarSide far;
    try
    {
        far = farSideOf(device, name);
    }
    catch (const device::DeviceError& error) // of sockets, where there is no ::1
    {
        GTEST_SKIP() << error.what();
    }
    const std::string show = fileOf("show");
    far.keep.push_back(removes(show));
    EXPECT_EQ(holds::trial(mode, far.open, far.transducers, show, far.sounds), "");
}

INSTANTIATE_TEST_SUITE_P(
    Matrix,
    Hold,
    testing::Combine(
        testing::ValuesIn(holds::allModes()),
        testing::Values("sim", "record", "serial", "autd3", "simulated_autd3", "driver", "list")),
    [](const auto& info) {
        return fmt::format(
            "{}_{}", holds::nameOf(std::get<0>(info.param)), std::get<1>(info.param));
    });

} // namespace
