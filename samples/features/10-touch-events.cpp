// Touch events: a finger taps a box, and the program is notified when a touch begins and ends, with
// place, depth and force.

#include "Frames.h"

#include <osgMidair/HapticSurface>

#include <osg/Shape>
#include <osg/ShapeDrawable>

#include <cmath>

namespace
{

class PrintTouches : public osgMidair::TouchCallback
{
public:
    void enter(const osgMidair::Touch& touch) override { print("enter", touch); }
    void leave(const osgMidair::Touch& touch) override { print("leave", touch); }

protected:
    ~PrintTouches() override = default;

private:
    static void print(const char* what, const osgMidair::Touch& touch)
    {
        std::printf("%.2f s  %s %s with %s of hand %d: %.1f mm deep, %.0f mm^2, at most %.2f mN\n",
                    touch.time,
                    what,
                    touch.node ? touch.node->getName().c_str() : "what is gone",
                    touch.bone.c_str(),
                    touch.hand,
                    1e3 * touch.depth,
                    1e6 * touch.area,
                    1e3 * touch.force);
    }
};

} // namespace

int main()
{
    constexpr double kHalfEdge_m = 0.02;
    const osg::ref_ptr<osgMidair::HapticSurface> box = new osgMidair::HapticSurface(
        new osg::ShapeDrawable(new osg::Box(osg::Vec3(), static_cast<float>(2.0 * kHalfEdge_m))));
    box->setName("box");
    box->setTouchEvents(true); // off by default

    const osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
    scene->addChild(box);
    scene->setTouchCallback(new PrintTouches); // for all objects; HapticSurface can have its own
    const osg::ref_ptr<osgMidair::InjectedHands> hands = new osgMidair::InjectedHands;
    scene->setHandSource(hands);

    // Once a second the index finger is 2 mm deep in the box.
    const auto tap = [&hands](double time_s)
    {
        const double height_m =
            kHalfEdge_m + 0.0075 + 0.010 + 0.012 * std::cos(2.0 * osg::PI * time_s);
        hands->setHands({osgMidair::openHand(
            1, osg::Vec3d(0, 0, height_m), osg::Quat(-osg::PI / 6.0, osg::Vec3d(1, 0, 0)))});
    };
    Frames(*scene).run(2.0, tap);
    return 0;
}
