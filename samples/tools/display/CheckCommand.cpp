#include "haptics/array/TransducerArray.h"
#include "haptics/base/InputError.h"
#include "haptics/base/text/Number.h"
#include "haptics/base/text/Words.h"
#include "haptics/boards/BoardMeasurements.h"
#include "samples/shared/DisplayOptions.h"
#include "samples/shared/ToolOptions.h"
#include "samples/shared/views/Offscreen.h"
#include "samples/tools/display/DisplayCommands.h"

#include <osg/Geometry>
#include <osg/LineWidth>
#include <osg/Matrixd>
#include <osgDB/WriteFile>
#include <osgViewer/Viewer>

#include <array>
#include <string>
#include <vector>

namespace midair::samples
{

namespace
{

constexpr double kCheckArm_m = 0.012; ///< arm of a cross
constexpr float kCheckWidth_px = 2.0F;

/// Parses sixteen numbers, row by row, as in the setting calibration; empty text: the identity.
osg::Matrixd matrixOf(const std::string& text)
{
    const std::vector<std::string> fields = base::splitColumns(text);
    if (fields.empty()) return {};
    std::array<double, 16> numbers{};
    bool isFine = fields.size() == numbers.size();
    for (std::size_t i = 0; isFine && i < numbers.size(); ++i)
        isFine = base::parseNumber(fields[i], numbers[i]);
    osg::Matrixd matrix(numbers.data());
    osg::Matrixd inverse;
    if (!isFine || !inverse.invert(matrix))
        throw base::InputError("--calibration should be the sixteen numbers of a matrix, row by "
                               "row, as midair-calibrate writes them");
    return matrix;
}

/// Returns crosses at the corners of all boards, with an arm along the normal: lines in the world.
osg::ref_ptr<osg::Node> arrayCrosses(const std::string& name, const osg::Matrixd& worldToArray)
{
    const haptics::TransducerArray array = haptics::TransducerArray::load(name);
    const haptics::BoardMarks marks(array);
    const osg::Matrixd toWorld = osg::Matrixd::inverse(worldToArray);
    const osg::ref_ptr<osg::Vec3Array> ends = new osg::Vec3Array;
    const auto add = [&](const Eigen::Vector3d& place)
    { ends->push_back(osg::Vec3d(place.x(), place.y(), place.z()) * toWorld); };
    for (int board = 0; board < marks.boards(); ++board)
    {
        const Eigen::Vector3d a = array.positions.col(marks.corner(board, 'a'));
        const Eigen::Vector3d b = array.positions.col(marks.corner(board, 'b'));
        const Eigen::Vector3d normal = array.normals.col(marks.corner(board, 'a'));
        const Eigen::Vector3d along = (b - a).normalized();
        for (const char letter : {'a', 'b', 'c', 'd'})
        {
            const Eigen::Vector3d at = array.positions.col(marks.corner(board, letter));
            for (const Eigen::Vector3d& arm : {along, Eigen::Vector3d(normal.cross(along))})
            {
                add(at - kCheckArm_m * arm);
                add(at + kCheckArm_m * arm);
            }
            add(at);
            add(at + kCheckArm_m * normal);
        }
    }
    const osg::ref_ptr<osg::Geometry> lines = new osg::Geometry;
    const osg::ref_ptr<osg::Vec4Array> colors = new osg::Vec4Array;
    colors->push_back(osg::Vec4(1.0F, 1.0F, 1.0F, 1.0F));
    lines->setVertexArray(ends);
    lines->setColorArray(colors, osg::Array::BIND_OVERALL);
    lines->addPrimitiveSet(new osg::DrawArrays(GL_LINES, 0, static_cast<int>(ends->size())));
    lines->getOrCreateStateSet()->setAttributeAndModes(new osg::LineWidth(kCheckWidth_px));
    lines->getOrCreateStateSet()->setMode(GL_LIGHTING, osg::StateAttribute::OFF);
    return lines;
}

class CheckCommand : public DisplayCommand
{
public:
    explicit CheckCommand(CLI::App& app) :
        _command(app.add_subcommand(
            "check",
            "shows a cross at each corner of the array's boards: each must cover its corner"))
    {
        _command
            ->add_option("FILE",
                         _file,
                         "the display's file; sim:FILE for a rehearsal; openxr: for a headset")
            ->required();
        _command->add_option("--array", _array, "a name or a file")->capture_default_str();
        _command->add_option(
            "--calibration", _calibration, "matrix from the world to the array, row by row");
        _command->add_option("--screen", _screen, "number of the screen")
            ->check(CLI::Range(0, 63))
            ->capture_default_str();
        _command->add_option("--out", _out, "write the picture to this file; no window is opened");
    }

    int run() override
    {
        if (!*_command) return -1;
        if (_file.empty()) throw base::InputError("FILE is empty");
        const osg::ref_ptr<osgMidair::DisplayView> display = openDisplay(_file);
        osgViewer::Viewer viewer;
        viewer.setLightingMode(osg::View::NO_LIGHT);
        viewer.setSceneData(arrayCrosses(_array, matrixOf(_calibration)));
        if (!_out.empty() && display)
        {
            picture(viewer, *display);
            return EXIT_DONE;
        }
        if (!haveDisplay())
            throw base::InputError(
                "can't open a window: DISPLAY is not set; --out FILE writes a picture instead");
        if (display)
            viewer.setUpViewOnSingleScreen(static_cast<unsigned int>(_screen));
        else
            viewer.setUpViewInWindow(40, 40, 640, 480, static_cast<unsigned int>(_screen));
        showOn(display, viewer);
        const osg::ref_ptr<osgMidair::HeadsetView> headset = showInHeadset(_file, viewer);
        if (!display && !headset) throw base::InputError("there is no headset to check");
        viewer.realize();
        viewer.run();
        return EXIT_DONE;
    }

private:
    void picture(osgViewer::Viewer& viewer, osgMidair::DisplayView& display) const
    {
        std::string error;
        const osg::ref_ptr<FrameGrabber> grabber = new FrameGrabber;
        if (!setUpOffscreen(viewer, display.getWidth(), display.getHeight(), 30.0, &error))
            throw base::InputError("no picture: " + error);
        showOn(&display, viewer);
        viewer.getCamera()->setFinalDrawCallback(grabber);
        viewer.frame();
        grabber->request();
        viewer.frame();
        if (!grabber->image() || !osgDB::writeImageFile(*grabber->image(), _out))
            throw base::InputError("can't write the picture to \"" + _out + "\"");
    }

    CLI::App* _command;
    std::string _file, _array = "board", _calibration, _out;
    int _screen = 0;
};

} // namespace

std::unique_ptr<DisplayCommand> addCheck(CLI::App& app)
{
    return std::make_unique<CheckCommand>(app);
}

} // namespace midair::samples
