-- Connects Neovim (0.7 or newer) with `espalier language-server`. Copy this file to ~/.config/nvim/plugin/.
-- vim.g.espalier_program: the program, when it is not on the PATH.

local group = vim.api.nvim_create_augroup("espalier", {})
local clients = {} -- by folder

local function is_lex(buffer)
  for _, line in ipairs(vim.api.nvim_buf_get_lines(buffer, 0, 50, false)) do
    if line:match("^%%[{%%]") then
      return true
    end
  end
  return false
end

local function client_of(folder)
  if not clients[folder] then
    clients[folder] = vim.lsp.start_client({
      name = "espalier",
      cmd = { vim.g.espalier_program or "espalier", "language-server" },
      root_dir = folder,
      on_exit = function()
        clients[folder] = nil
      end,
    })
  end
  return clients[folder]
end

vim.api.nvim_create_autocmd({ "BufReadPost", "BufNewFile" }, {
  group = group,
  pattern = { "*.l", "*.v", "*.ls", "*.lpy" },
  callback = function(event)
    if is_lex(event.buf) then
      return
    end
    vim.bo[event.buf].filetype = "espalier"
    vim.bo[event.buf].commentstring = "/* %s */"
    local client = client_of(vim.fn.fnamemodify(event.file, ":p:h"))
    if client then
      vim.lsp.buf_attach_client(event.buf, client)
      local keys = { buffer = event.buf }
      vim.keymap.set("n", "K", vim.lsp.buf.hover, keys)
      vim.keymap.set("n", "gd", vim.lsp.buf.definition, keys)
      vim.keymap.set("n", "gr", vim.lsp.buf.references, keys)
      vim.keymap.set("n", "<leader>r", vim.lsp.buf.rename, keys)
      vim.bo[event.buf].omnifunc = "v:lua.vim.lsp.omnifunc"
    end
  end,
})
