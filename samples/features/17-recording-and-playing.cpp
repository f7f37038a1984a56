// Recording: a scene's output is written to a file, read back, and played on a device without the
// scene.

#include "Frames.h"

#include <osgMidair/HapticPoints>
#include <osgMidair/Recording>

#include <algorithm>

int main(int argc, char** argv)
{
    const std::string file = argc > 1 ? argv[1] : "touch.midair";
    {
        const osg::ref_ptr<osgMidair::HapticPoints> point = new osgMidair::HapticPoints;
        const osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
        scene->setArray("board");
        scene->setDevice("record:" + file); // "usb:,record:.." also plays
        scene->addChild(point);
        const auto move = [&point](double time_s)
        { point->setPoints({osg::Vec3d(0.05 * std::min(time_s, 1.0), 0.0, 0.15)}); };
        Frames(*scene).run(1.0, move);
    } // the scene's destructor silences the array and ends the recording

    std::string error;
    const osg::ref_ptr<osgMidair::RecordingReader> reader =
        osgMidair::RecordingReader::open(file, error);
    osgMidair::RecordedField field;
    int fields = 0;
    while (reader && reader->next(field))
        ++fields;
    if (!reader || !reader->getError().empty())
    {
        std::fprintf(stderr, "%s\n", reader ? reader->getError().c_str() : error.c_str());
        return 1;
    }
    std::printf("%d entries for %u transducers\n", fields, reader->getNumTransducers());

    osgMidair::PlayerOptions options;
    options.speed = 2.0;
    options.maxAmplitude = 0.5;
    const osg::ref_ptr<osgMidair::Player> player =
        osgMidair::Player::open(file, "sim:", error, options);
    if (!player)
    {
        std::fprintf(stderr, "%s\n", error.c_str());
        return 1;
    }
    float most = 0.0F;
    while (!player->isFinished())
    {
        for (const std::complex<float>& q : player->getActivations())
            most = std::max(most, std::abs(q));
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    std::printf("played with amplitudes up to %.2f: %s\n", most, player->getStatus().c_str());
    return 0;
}
