#include "plugin/display/GlxContext.h"

#include <array>

#include <GL/glx.h>
#include <dlfcn.h>

namespace osgMidair
{

namespace
{

/// A function of OSG's libGL; a viewer without GLX may lack it.
template<typename F>
F glxFunction(const char* name)
{
    void* found = dlsym(RTLD_DEFAULT, name);
    for (const char* library : {"libGL.so.1", "libGLX.so.0"})
        if (!found)
            if (void* opened = dlopen(library, RTLD_LAZY | RTLD_NOLOAD))
            {
                found = dlsym(opened, name);
                dlclose(opened);
            }
    return reinterpret_cast<F>(found);
}

#define MIDAIR_GLX(name) glxFunction<decltype(&::name)>(#name)

} // namespace

midair::bridge::OpenXrGraphics currentGlx(std::string& error)
{
    const auto display = MIDAIR_GLX(glXGetCurrentDisplay);
    const auto context = MIDAIR_GLX(glXGetCurrentContext);
    const auto drawable = MIDAIR_GLX(glXGetCurrentDrawable);
    const auto query = MIDAIR_GLX(glXQueryContext);
    const auto choose = MIDAIR_GLX(glXChooseFBConfig);
    const auto attribute = MIDAIR_GLX(glXGetFBConfigAttrib);
    midair::bridge::OpenXrGraphics graphics;
    if (!display || !context || !drawable || !query || !choose || !attribute || !context())
    {
        error = "the viewer's window is not a GLX window, which OpenXR needs here";
        return graphics;
    }
    Display* const x = display();
    graphics.display = x;
    graphics.context = context();
    graphics.drawable = drawable();
    // OSG creates its context from a visual; the context knows the matching configuration.
    int id = 0;
    query(x, context(), GLX_FBCONFIG_ID, &id);
    int screen = 0;
    query(x, context(), GLX_SCREEN, &screen);
    const std::array<int, 3> wanted = {GLX_FBCONFIG_ID, id, None};
    int count = 0;
    GLXFBConfig* configs = choose(x, screen, wanted.data(), &count);
    if (configs && count > 0)
    {
        graphics.config = configs[0];
        int visual = 0;
        attribute(x, configs[0], GLX_VISUAL_ID, &visual);
        graphics.visual = static_cast<std::uint32_t>(visual);
    }
    else
        error = "the viewer's window has no GLX configuration";
    if (configs)
        if (const auto release = glxFunction<int (*)(void*)>("XFree")) release(configs);
    return graphics;
}

void stopWaitingForScreen()
{
    const auto address = MIDAIR_GLX(glXGetProcAddressARB);
    const auto display = MIDAIR_GLX(glXGetCurrentDisplay);
    const auto drawable = MIDAIR_GLX(glXGetCurrentDrawable);
    if (!address || !display || !drawable || !display()) return;
    using Interval = void (*)(Display*, GLXDrawable, int);
    const auto interval =
        reinterpret_cast<Interval>(address(reinterpret_cast<const GLubyte*>("glXSwapIntervalEXT")));
    const auto extensions = MIDAIR_GLX(glXQueryExtensionsString);
    const char* const offered = extensions ? extensions(display(), DefaultScreen(display())) : "";
    if (interval && offered &&
        std::string(offered).find("GLX_EXT_swap_control") != std::string::npos)
        interval(display(), drawable(), 0);
}

#undef MIDAIR_GLX

} // namespace osgMidair
