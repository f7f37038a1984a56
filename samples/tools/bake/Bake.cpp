#include "samples/tools/bake/Bake.h"

#include "device/recording/Recording.h"
#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"
#include "haptics/base/text/Number.h"
#include "samples/shared/shards/Shards.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdio>

#include <fmt/format.h>
#include <unistd.h>

namespace midair::samples
{

namespace
{

namespace recording = device::recording;

/// What a shard's frames have become, for the last line.
struct Baked
{
    std::uint64_t frames = 0;
    std::uint64_t fields = 0;
    std::uint64_t silent = 0; ///< frames
    std::uint64_t silenced = 0;
    double worstRms = 0.0;
    std::uint64_t points = 0; ///< most of a frame
};

void append(std::string& bytes, const std::vector<std::uint8_t>& more)
{
    bytes.append(more.begin(), more.end());
}

/// Solves a chunk from nothing. A payload is a recording by itself.
std::string
bakeChunk(BakeScene& scene, const BakeArguments& arguments, std::uint64_t chunk, Baked& baked)
{
    scene.restart();
    recording::Writer writer(static_cast<int>(scene.transducers()));
    std::string bytes;
    append(bytes, writer.header(0));
    const auto size = static_cast<std::uint64_t>(arguments.chunk);
    const std::uint64_t end = std::min((chunk + 1) * size, arguments.frames());
    for (std::uint64_t number = chunk * size; number < end; ++number)
    {
        const osgMidair::BakedFrame frame = scene.bake(number);
        for (const osgMidair::BakedField& field : frame.fields)
            append(bytes,
                   field.phase.empty() ? writer.mark(field.time_ns, recording::Kind::SILENCE)
                                       : writer.field(field.time_ns, {field.phase, field.duty}));
        ++baked.frames;
        baked.fields += frame.fields.size();
        if (frame.fields.front().phase.empty()) ++baked.silent;
        if (frame.isSilenced) ++baked.silenced;
        baked.worstRms = std::max(baked.worstRms, frame.rms);
        baked.points = std::max<std::uint64_t>(baked.points, frame.points);
    }
    append(bytes, writer.mark(arguments.time_ns(end), recording::Kind::END));
    return bytes;
}

void tell(const std::string& line)
{
    std::fprintf(stderr, "midair-bake: %s\n", line.c_str());
}

void tellResult(const Baked& baked, const BakeScene& scene)
{
    for (const std::string& message : scene.messages())
        tell(message);
    if (baked.frames == 0) return;
    std::printf("%llu frames, %llu fields; at most %llu points, rms error at most %.3f %%\n",
                static_cast<unsigned long long>(baked.frames),
                static_cast<unsigned long long>(baked.fields),
                static_cast<unsigned long long>(baked.points),
                100.0 * baked.worstRms);
    if (baked.silent > 0)
        std::printf("%llu of these frames are silent, %llu of them by caps\n",
                    static_cast<unsigned long long>(baked.silent),
                    static_cast<unsigned long long>(baked.silenced));
}

namespace recording = device::recording;
using device::DriveSignal;

constexpr int kLevels = 256;
constexpr std::uint64_t kMostPlayed = std::uint64_t(2) << 30; // bytes of what play: takes

std::string framesOf(const nlohmann::json& work, std::uint64_t piece)
{
    const auto first = work.value("firstFrame", std::int64_t(0));
    const auto end = work.value("endFrame", std::int64_t(0));
    const auto chunk = work.value("chunk", std::int64_t(1));
    const std::int64_t begin = first + static_cast<std::int64_t>(piece) * chunk;
    return fmt::format("frames {} to {}", begin, std::min(begin + chunk, end) - 1);
}

/// Returns by how many levels all phases of \a next are to be turned, which can't be felt, so that
/// the drive changes least from \a last: argmax over r of Re sum a a' e^{j 2 pi (next + r -
/// last)/256}, with amplitudes by the levels of duty.
int turnBetween(const DriveSignal& last, const DriveSignal& next)
{
    // Whole numbers up to here, so that the order of the sum doesn't matter.
    std::array<double, kLevels> weights{};
    for (std::size_t i = 0; i < next.phase.size() && i < last.phase.size(); ++i)
    {
        const auto step = static_cast<std::uint8_t>(next.phase[i] - last.phase[i]);
        weights[step] += static_cast<double>(last.duty[i]) * next.duty[i];
    }
    std::complex<double> sum = 0.0;
    for (int step = 0; step < kLevels; ++step)
        sum += weights[static_cast<std::size_t>(step)] *
               std::polar(1.0, base::kTwoPi * step / kLevels);
    if (std::abs(sum) == 0.0) return 0;
    const long turn = std::lround(-std::arg(sum) * kLevels / base::kTwoPi);
    return static_cast<int>((turn + kLevels) % kLevels);
}

/// Puts chunks behind each other.
class Joiner
{
public:
    Joiner(int transducers, WholeFile& file) :
        _transducers(transducers),
        _writer(transducers),
        _file(file)
    {
        put(_writer.header(0));
    }

    void add(const std::string& payload, const std::string& name)
    {
        recording::Reader reader(payload, name);
        if (reader.transducers() != _transducers)
            throw base::InputError(name + " is for another number of transducers");
        bool isFirst = true;
        recording::Entry entry;
        recording::Stop stop = recording::Stop::MORE;
        while ((stop = reader.next(entry)) == recording::Stop::MORE)
        {
            if (entry.kind == recording::Kind::SILENCE)
            {
                put(_writer.mark(entry.time_ns, recording::Kind::SILENCE));
                _last = {};
                continue;
            }
            // What starts from nothing has its phases by chance.
            if (isFirst) _turn = _last.phase.empty() ? 0 : turnBetween(_last, entry.signal);
            isFirst = false;
            for (std::uint8_t& phase : entry.signal.phase)
                phase = static_cast<std::uint8_t>(phase + _turn);
            put(_writer.field(entry.time_ns, entry.signal));
            _last = entry.signal;
            ++_fields;
        }
        if (stop != recording::Stop::END) throw base::InputError(name + " breaks off");
    }

    void end(std::uint64_t time_ns) { put(_writer.mark(time_ns, recording::Kind::END)); }
    std::uint64_t fields() const { return _fields; }

private:
    void put(const std::vector<std::uint8_t>& bytes) { _file.write(bytes.data(), bytes.size()); }

    const int _transducers;
    recording::Writer _writer;
    WholeFile& _file;
    DriveSignal _last; ///< empty: silence
    int _turn = 0;
    std::uint64_t _fields = 0;
};

} // namespace

int bake(const BakeArguments& arguments)
{
    const Shard shard = parseShard(arguments.shard);
    const bool isWhole = shard.count == 1;
    BakeScene scene(arguments);
    for (const std::string& note : scene.notes())
        tell(note);
    PartHeader header{scene.work(), shard.number, shard.count, arguments.chunks()};
    if (isWhole) WholeFile(arguments.out, recording::kMagic, arguments.overwrite); // told now
    const std::string file = isWhole ? arguments.out + ".part" : arguments.out;
    Baked baked;
    {
        PartFile part = PartFile::openToGoOn(file, header);
        if (!part.damage().empty())
            tell(fmt::format("\"{}\": {}; solved again", file, part.damage()));
        if (part.pieces() > 0)
            tell(fmt::format("\"{}\" has {} of {} chunks already, which are kept",
                             file,
                             part.pieces(),
                             header.share()));
        const auto size = static_cast<std::uint64_t>(arguments.chunk);
        Progress progress("frames",
                          std::min(part.pieces() * size, arguments.frames()),
                          isWhole ? arguments.frames()
                                  : std::min(header.share() * size, arguments.frames()),
                          arguments.quiet);
        for (std::uint64_t chunk = 0; chunk < header.pieces; ++chunk)
        {
            if (!header.has(chunk) || part.has(chunk)) continue;
            const std::uint64_t before = baked.frames;
            part.add(chunk, bakeChunk(scene, arguments, chunk, baked));
            progress.add(baked.frames - before);
        }
        part.sync();
    }
    tellResult(baked, scene);
    if (isWhole)
    {
        mergeBaked({file}, arguments.out, arguments.overwrite);
        ::unlink(file.c_str());
    }
    return baked.frames > 0 && baked.silent == baked.frames ? 1 : 0;
}

void mergeBaked(const std::vector<std::string>& parts, const std::string& out, bool overwrite)
{
    const JoinedParts joined(parts, framesOf);
    const nlohmann::json& work = joined.work();
    if (work.value("what", "") != "midair-bake 1")
        throw base::InputError(fmt::format("\"{}\" is no part of midair-bake, but of {}",
                                           parts.front(),
                                           work.value("what", "something else")));
    BakeArguments arguments;
    arguments.first = work.value("firstFrame", std::int64_t(0));
    arguments.end = work.value("endFrame", std::int64_t(0));
    arguments.fps = work.value("fps", 60.0);
    const std::string transducers =
        work.contains("settings") ? work["settings"].value("transducers", "0") : "0";
    int count = 0;
    if (!base::parseWhole(transducers, count) || count < 1 || count > recording::kMostTransducers)
        throw base::InputError(fmt::format("\"{}\" is for \"{}\" transducers, should be 1 .. {}",
                                           parts.front(),
                                           transducers,
                                           recording::kMostTransducers));
    WholeFile file(out, recording::kMagic, overwrite);
    Joiner joiner(count, file);
    for (std::uint64_t piece = 0; piece < joined.pieces(); ++piece)
        joiner.add(joined.read(piece), framesOf(work, piece));
    joiner.end(arguments.time_ns(arguments.frames()));
    file.commit();
    std::printf("%s: %llu fields, %.3f s, %llu bytes\n",
                out.c_str(),
                static_cast<unsigned long long>(joiner.fields()),
                1e-9 * static_cast<double>(arguments.time_ns(arguments.frames())),
                static_cast<unsigned long long>(file.size()));
    if (file.size() > kMostPlayed)
        std::fprintf(stderr,
                     "midair-bake: play: takes recordings of at most 2 GiB; bake shorter ranges of "
                     "frames\n");
}

} // namespace midair::samples
