// Baking: solves the frames of an animation one by one, as accurately as the kit can, writes them
// to a file for any device, and reads it back. midair-bake does this for scene files, on many
// machines.

#include <osgMidair/FieldBaker>
#include <osgMidair/HapticScene>
#include <osgMidair/HapticSurface>
#include <osgMidair/Recording>

#include <osg/MatrixTransform>
#include <osg/Shape>
#include <osg/ShapeDrawable>

#include <cstdio>
#include <string>

int main(int argc, char** argv)
{
    const std::string file = argc > 1 ? argv[1] : "baked.midair";
    constexpr unsigned int kFrames = 6;
    constexpr double kRate_Hz = 60.0;
    const osg::ref_ptr<osg::MatrixTransform> carried = new osg::MatrixTransform;
    carried->addChild(
        new osgMidair::HapticSurface(new osg::ShapeDrawable(new osg::Sphere(osg::Vec3(), 0.015F))));
    const osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
    scene->addChild(carried);

    const osg::ref_ptr<osgMidair::FieldBaker> baker = new osgMidair::FieldBaker(*scene);
    osg::ref_ptr<osgMidair::RecordingWriter> writer; // needs the array's size
    std::string error;
    unsigned int even = 0;
    const auto at_ns = [](unsigned int k)
    { return static_cast<std::uint64_t>(1e9 * k / kRate_Hz); };
    for (unsigned int i = 0; i < kFrames; ++i)
    {
        const osg::ref_ptr<osg::FrameStamp> stamp = new osg::FrameStamp;
        stamp->setFrameNumber(i);
        stamp->setSimulationTime(i / kRate_Hz);
        carried->setMatrix(osg::Matrix::translate(0.001 * i, 0.0, 0.0)); // stands for the update
                                                                         // traversal
        osgMidair::BakedFrame frame;
        if (!baker->bake(*stamp, osg::Matrixd(), at_ns(i), at_ns(i + 1), frame, error))
        {
            std::fprintf(stderr, "%s\n", error.c_str());
            return 1;
        }
        if (!writer) writer = new osgMidair::RecordingWriter(baker->getNumTransducers());
        for (const osgMidair::BakedField& field : frame.fields)
            writer->record(field);
        if (frame.isEvened) ++even;
        if (i == 0) std::printf("%u points, %.0f Pa\n", frame.points, frame.level_Pa);
    }
    writer->end(at_ns(kFrames));
    if (!writer->save(file, error))
    {
        std::fprintf(stderr, "%s\n", error.c_str());
        return 1;
    }
    const osg::ref_ptr<osgMidair::RecordingReader> reader =
        osgMidair::RecordingReader::open(file, error);
    std::size_t bytes = 0;
    osgMidair::BakedField field;
    while (reader && reader->next(field))
        bytes += field.phase.size() + field.duty.size();
    std::printf("%u frames of %u transducers, %zu bytes, %u of them even over the surface\n",
                kFrames,
                baker->getNumTransducers(),
                bytes,
                even);
    return 0;
}
