#!/usr/bin/env python3
"""Path-trace a frame by Blender's Cycles, for comparison: python3 path_trace.py TABLE METADATA OUT SCENE [SAMPLES [WIDTH]]

TABLE is a frame as CSV (scree export RUN --to csv, or a table of x, y, z, radius), METADATA what scree inspect --write finds for it: camera, colours
and surfaces are its own. SCENE is quarry, desert_noon or desert_dusk, or any other word for a grey room. Needs Python 3.11 and the packages
bpy (5.0), pandas and pyyaml."""
import sys, numpy as np, pandas as pd, yaml, os
import bpy
from mathutils import Quaternion, Vector
table, md, out, scene = sys.argv[1:5]
spp = int(sys.argv[5]) if len(sys.argv) > 5 else 48
W = int(sys.argv[6]) if len(sys.argv) > 6 else 960
M = yaml.safe_load(open(md))
t = pd.read_csv(table)
t.columns = [c.split(' [')[0] for c in t.columns]
if 'class' not in t: t['class'] = 'particles'
rows = [{('cls' if k == 'class' else k): v for k, v in r.items()} for r in t.to_dict('records')]
bpy.ops.wm.read_factory_settings(use_empty=True)
S = bpy.context.scene
S.render.engine = 'CYCLES'
S.cycles.samples = spp
S.cycles.use_denoising = False
S.cycles.max_bounces = 6
S.render.threads_mode='FIXED'; S.render.threads=2
S.render.resolution_x, S.render.resolution_y = W, W * 9 // 16; S.view_settings.view_transform = 'Filmic'
for look in ['Medium High Contrast','Filmic - Medium High Contrast','AgX - Medium High Contrast']:
    try: S.view_settings.look = look; break
    except TypeError: pass
S.view_settings.exposure = -.2; S.render.filepath = out; S.render.image_settings.file_format='PNG'
w = bpy.data.worlds.new('w'); S.world = w; w.use_nodes = True; n = w.node_tree.nodes
bg = n.get('Background') or n.new('ShaderNodeBackground')
if not n.get('World Output'): o = n.new('ShaderNodeOutputWorld'); w.node_tree.links.new(bg.outputs[0], o.inputs[0])
SUN = {'quarry': (.78,.12,.5), 'desert_dusk': (-.9,-.36,.22), 'desert_noon': (-.25,-.3,.92)}
if scene in SUN:
    sky = n.new('ShaderNodeTexSky')
    for t in ['NISHITA','MULTIPLE_SCATTERING','SINGLE_SCATTERING']:
        try: sky.sky_type = t; break
        except TypeError: pass
    x,y,z = SUN[scene]; L=(x*x+y*y+z*z)**.5
    sky.sun_elevation = np.arcsin(z/L); sky.sun_rotation = np.arctan2(x,y)   # from +y clockwise
    sky.sun_size = np.radians(.8); sky.air_density = 1.0
    for k in ('dust_density','aerosol_density'):
        if hasattr(sky,k): setattr(sky,k,.8)
    w.node_tree.links.new(sky.outputs[0], bg.inputs[0])
    bg.inputs[1].default_value = .075 if scene!='desert_dusk' else .14
else:
    bg.inputs[0].default_value=(.55,.58,.62,1); bg.inputs[1].default_value=.55
    l=bpy.data.lights.new('key','SUN')
    l.energy=2.6
    l.angle=np.radians(8)
    l.color=(1,.96,.9)
    lo=bpy.data.objects.new('key',l)
    S.collection.objects.link(lo)
    lo.rotation_euler=Vector((.6,.45,-.75)).to_track_quat('-Z','Y').to_euler()
def mat(name, base, rough, scale, spread, bump, metal=0., alpha=1.):
    m = bpy.data.materials.new(name)
    m.use_nodes = True
    t = m.node_tree
    b = t.nodes['Principled BSDF']
    b.inputs['Roughness'].default_value = rough
    b.inputs['Metallic'].default_value=metal
    b.inputs['Alpha'].default_value=alpha
    (b.inputs.get('Specular IOR Level') or b.inputs.get('Specular')).default_value=.25
    tc = t.nodes.new('ShaderNodeTexCoord')
    no = t.nodes.new('ShaderNodeTexNoise')
    no.inputs['Scale'].default_value = scale
    no.inputs['Detail'].default_value = 12
    no.inputs['Roughness'].default_value = .65
    t.links.new(tc.outputs['Object'], no.inputs['Vector'])
    r = t.nodes.new('ShaderNodeValToRGB')
    r.color_ramp.elements[0].position, r.color_ramp.elements[1].position = .32, .68
    lo, hi = [tuple(c * f for c in base) + (1,) for f in (1 - spread, 1 + spread)]
    r.color_ramp.elements[0].color, r.color_ramp.elements[1].color = lo, hi
    t.links.new(no.outputs['Fac'], r.inputs['Fac'])
    col = r.outputs[0]
    if name.startswith('stone'):
        oi = t.nodes.new('ShaderNodeObjectInfo')
        hsv = t.nodes.new('ShaderNodeHueSaturation')
        mr = t.nodes.new('ShaderNodeMapRange')
        mr.inputs['To Min'].default_value, mr.inputs['To Max'].default_value = .55, 1.35
        t.links.new(oi.outputs['Random'], mr.inputs['Value'])
        t.links.new(mr.outputs[0], hsv.inputs['Value'])
        t.links.new(col, hsv.inputs['Color'])
        col = hsv.outputs[0]
    t.links.new(col, b.inputs['Base Color'])
    bp = t.nodes.new('ShaderNodeBump')
    bp.inputs['Strength'].default_value = bump
    bp.inputs['Distance'].default_value = .01
    t.links.new(no.outputs['Fac'], bp.inputs['Height'])
    t.links.new(bp.outputs[0], b.inputs['Normal'])
    return m
stone = mat('stone', (.30, .25, .20), .85, 9, .45, .6)
sand = mat('sand', (.50, .38, .25), .95, 3, .22, .8) if scene in SUN else mat('floor', (.6,.6,.6), .8, 1, .02, 0)
rng = np.random.default_rng(3); rocks = []
for k in range(8):
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=4, radius=1); o = bpy.context.object
    t = bpy.data.textures.new(f't{k}', 'VORONOI')
    t.noise_scale = 1.1
    m = o.modifiers.new('d', 'DISPLACE')
    m.texture = t
    m.strength = -.55
    m.mid_level = .35
    m.texture_coords = 'GLOBAL'
    o.location = rng.uniform(-50, 50, 3)
    t2 = bpy.data.textures.new(f'u{k}', 'CLOUDS')
    t2.noise_scale = .35
    m2 = o.modifiers.new('e', 'DISPLACE')
    m2.texture = t2
    m2.strength = .12
    m2.texture_coords = 'GLOBAL'
    for x in list(o.modifiers): bpy.ops.object.modifier_apply(modifier=x.name)
    o.location = (0, 0, 0)
    v = np.array([p.co for p in o.data.vertices])
    f = 1.02 / np.linalg.norm(v, axis=1).max()
    for p in o.data.vertices: p.co = p.co * f
    o.data.materials.append(stone); rocks.append(o.data); bpy.data.objects.remove(o)
mats = {}
def look(o, sh):
    c, op = o.get('color'), o.get('opacity', 1) or 1
    s, c = o['surface']['name'], c if isinstance(c, list) else [.3, .25, .2]
    key = (s, tuple(c), op)
    if key not in mats:
        mats[key] = {'paintedmetal': lambda: mat('paint', c, .35, 6, .06, .05, 0., op), 'concrete': lambda: mat('concrete', c, .8, 6, .22, .35, 0., op), 'gravel': lambda: mat('gravel', c, .85, 9, .3, .5),
                     'plastic': lambda: mat('plastic', c, .4, 6, .03, 0., 0., op)}.get(s, lambda: mat('other', c, .6, 6, .05, .1, 0., op))()
    return mats[key]
# Formulas of the metadata are Python's, but for the column `class`.
formula = lambda f, r: eval(str(f).replace('class', 'cls'), {}, r)
ballmesh = None
for obj in M['objects']:
    (sh, g), = obj['geometry'].items()
    for i, row in enumerate(rows):
        if sh == 'plane' or not formula(obj.get('select', True), row): continue
        m = look(obj, sh)
        if sh == 'sphere':
            r = formula(g['radius'], row)
            if obj.get('displacement'): mesh = rocks[int(row.get('id', i)) % 8]
            else:
                if ballmesh is None:
                    bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24, radius=1)
                    q = bpy.context.object
                    bpy.ops.object.shade_smooth()
                    ballmesh = q.data
                    bpy.data.objects.remove(q)
                    ballmesh.materials.append(m)
                mesh = ballmesh
            o = bpy.data.objects.new('s', mesh)
            S.collection.objects.link(o)
            o.scale = [r] * 3
        elif sh == 'cylinder':
            r, h = formula(g['radius'], row), formula(g['half'], row)
            bpy.ops.mesh.primitive_cylinder_add(vertices=64, radius=r, depth=2 * h)
            o = bpy.context.object
            b = o.modifiers.new('b', 'BEVEL')
            b.width = .04 * r
            b.segments = 3
            b.limit_method = 'ANGLE'
            o.data.materials.append(m)
        else:
            half = [formula(f, row) for f in g['half']]
            bpy.ops.mesh.primitive_cube_add(size=2)
            o = bpy.context.object
            o.scale = half
            bpy.ops.object.transform_apply(location=False, rotation=False, scale=True)
            b = o.modifiers.new('b', 'BEVEL')
            b.width = min(.012, .15 * min(half))
            b.segments = 3
            o.data.materials.append(m)
        o.location = [formula(f, row) for f in obj.get('position', ['pos_x', 'pos_y', 'pos_z'])]
        turn = obj.get('orientation', ['quat_w', 'quat_x', 'quat_y', 'quat_z'] if 'quat_w' in row else [1, 0, 0, 0])
        o.rotation_mode = 'QUATERNION'
        o.rotation_quaternion = [formula(f, row) for f in turn]
gz = float(M.get('ground_height') or 0)
bpy.ops.mesh.primitive_plane_add(size=600, location=(0,0,gz)); bpy.context.object.data.materials.append(sand)
if scene in SUN:
    for _ in range(2500):
        o = bpy.data.objects.new('p', rocks[rng.integers(8)])
        x = rng.normal(0, 2.6, 2)
        o.location = (*x, gz)
        r = .004 + .012 * rng.random() ** 3
        o.scale = (r, r, r * .8)
        o.rotation_euler = rng.uniform(0, 6.28, 3)
        S.collection.objects.link(o)
C = M['camera']
c = bpy.data.cameras.new('c')
c.sensor_fit = 'VERTICAL'
c.angle_y = np.radians(C.get('fov', 35))
co = bpy.data.objects.new('c', c)
S.collection.objects.link(co)
e, l = Vector(C['eye']), Vector(C['look_at'])
co.location = e
co.rotation_euler = (l - e).to_track_quat('-Z', 'Y').to_euler()
S.camera = co
c.clip_end = 1000
t0 = os.times()
bpy.ops.render.render(write_still=True)
t1 = os.times()
print('CPU-seconds', out, round(t1.user - t0.user + t1.system - t0.system, 1))
