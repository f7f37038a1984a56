#include <osgMidair/HapticScene>
#include <osgMidair/HapticSurface>

#include <osg/ShapeDrawable>

#include <chrono>
#include <iostream>
#include <thread>

/// Plays a box in the simulated octagonal array and says how.
int main()
{
    osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
    osg::ref_ptr<osgMidair::HapticSurface> surface =
        new osgMidair::HapticSurface(new osg::ShapeDrawable(new osg::Box(osg::Vec3(), 0.03f)));
    surface->setSampling(osgMidair::HapticProperty::VERTICES);
    scene->addChild(surface);
    scene->update(nullptr);
    for (int i = 0; i < 1000 && scene->getStatistics().solves == 0; ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    std::cout << scene->getStatistics().points << " points\n";
    return scene->getStatistics().points == 8 ? 0 : 1;
}
