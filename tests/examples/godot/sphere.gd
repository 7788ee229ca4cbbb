extends Spatial

const TO_LIGHT = Vector3(-2, 3, 4)


func _ready():
	var prefix = argument("--atlas", "material")
	var material = ShaderMaterial.new()
	material.shader = Shader.new()
	material.shader.code = text_of("res://sphere.shader").replace("// sbrdf_eval", sbrdf_eval(prefix + ".glsl"))
	material.set_shader_param("sbrdf_atlas", atlas(prefix + ".exr"))
	$Sphere.mesh = sphere()
	$Sphere.material_override = material
	$Light.look_at_from_position(TO_LIGHT, Vector3(0, 0, 0), Vector3(0, 1, 0))
	var picture = argument("--picture", "")
	if picture != "":
		save_picture(picture)


# A filtered texture, clamped to its edges, without mip levels. A file that is loaded like this is not imported; where
# one is: Filter on, Repeat off, Mipmaps off, sRGB disabled, not compressed.
func atlas(path):
	var image = Image.new()
	if image.load(path) != OK:
		fail("cannot read " + path)
	var texture = ImageTexture.new()
	texture.create_from_image(image, Texture.FLAG_FILTER)
	return texture


# Godot 3 has no preprocessor: the lines that begin with # are left out, and the name of the sampler is put in.
func sbrdf_eval(path):
	var text = ""
	for line in text_of(path).split("\n"):
		if not line.begins_with("#"):
			text += line + "\n"
	return text.replace("SBRDF_ATLAS", "sbrdf_atlas")


# Godot 3 packs the normals and tangents of its meshes into bytes, which a narrow highlight shows. Here they are made
# anew, and kept as floats by the last argument.
func sphere():
	var primitive = SphereMesh.new()
	primitive.radius = 1
	primitive.height = 2
	primitive.radial_segments = 512
	primitive.rings = 256
	var arrays = primitive.get_mesh_arrays()
	var tangents = PoolRealArray()
	for point in arrays[Mesh.ARRAY_VERTEX]:
		var tangent = Vector3(0, 1, 0).cross(point).normalized()
		tangents.append_array(PoolRealArray([tangent.x, tangent.y, tangent.z, 1]))
	arrays[Mesh.ARRAY_NORMAL] = arrays[Mesh.ARRAY_VERTEX]
	arrays[Mesh.ARRAY_TANGENT] = tangents
	var mesh = ArrayMesh.new()
	mesh.add_surface_from_arrays(Mesh.PRIMITIVE_TRIANGLES, arrays, [], 0)
	return mesh


func text_of(path):
	var file = File.new()
	if file.open(path, File.READ) != OK:
		fail("cannot read " + path)
	return file.get_as_text()


func argument(name, otherwise):
	for word in OS.get_cmdline_args():
		if word.begins_with(name + "="):
			return word.substr(name.length() + 1)
	return otherwise


func save_picture(path):
	yield(VisualServer, "frame_post_draw")
	yield(VisualServer, "frame_post_draw")
	var image = get_viewport().get_texture().get_data()
	image.flip_y()
	if image.save_png(path) != OK:
		fail("cannot write " + path)
	get_tree().quit()


func fail(message):
	printerr(message)
	OS.exit_code = 1
	get_tree().quit()
