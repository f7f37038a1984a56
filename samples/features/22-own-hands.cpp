// A custom tracker: a class that returns hands, registered with a name, so that users and files can
// write hands=mine:.. like hands=openxr:.

#include "Frames.h"

#include <osgMidair/HandSourceFactory>
#include <osgMidair/HapticSurface>

#include <osg/Shape>
#include <osg/ShapeDrawable>

#include <cmath>

namespace
{

/// Stands for a tracker: a finger that moves in a circle and is lost on the far side.
class CirclingHand : public osgMidair::HandSource
{
public:
    explicit CirclingHand(double radius_m) : _radius_m(radius_m) {}
    bool getHands(double time, std::vector<osgMidair::Hand>& hands) override
    {
        const double angle = 2.0 * osg::PI * time;
        hands.clear();
        if (std::cos(angle) < -0.5) return false; // not visible
        hands.push_back(osgMidair::openHand(
            0,
            osg::Vec3d(_radius_m * std::cos(angle), _radius_m * std::sin(angle), 0.02),
            osg::Quat(-osg::PI / 3.0, osg::Vec3d(1, 0, 0))));
        return true;
    }
    std::string getStatus() const override { return "a hand that goes round in circles"; }

private:
    double _radius_m;
};

} // namespace

int main()
{
    std::string error;
    const osgMidair::HandSourceFactory make =
        [](const std::string& options, std::string& why) -> osg::ref_ptr<osgMidair::HandSource>
    {
        const double radius_mm = std::atof(options.c_str());
        if (radius_mm > 0.0) return new CirclingHand(1e-3 * radius_mm);
        why = "\"" + options + "\" is no radius in mm";
        return nullptr;
    };
    if (!osgMidair::registerHandSource("circle", make, error)) return 1;

    const osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
    scene->addChild(
        new osgMidair::HapticSurface(new osg::ShapeDrawable(new osg::Sphere(osg::Vec3(), 0.02F))));
    scene->setHands("circle:15");
    int seen = 0;
    int lost = 0;
    const auto count = [&](double /*time_s*/)
    { ++(scene->getStatistics().hands > 0 ? seen : lost); };
    Frames frames(*scene);
    if (!frames.untilPlayed()) return 1;
    frames.run(2.0, count);
    std::printf("seen in %s of %d frames\n", seen > lost ? "most" : "few", seen + lost);

    scene->setHands("circle:x"); // can't be opened, which causes a message
    frames.run(0.2);
    std::printf("%s\n", scene->getStatistics().messages.back().c_str());
    return 0;
}
