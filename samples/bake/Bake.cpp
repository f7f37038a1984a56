#include "samples/bake/Bake.h"

#include "device/recording/Recording.h"
#include "haptics/base/InputError.h"
#include "samples/shards/Shards.h"

#include <algorithm>
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

} // namespace midair::samples
